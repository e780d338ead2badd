// A tank to play with: what hands do here is simulated by the program that gave out this page.

import type { Poured } from "./asking";
import { type Basin, Picture } from "./basin";
import { bytes, DEGREE, element, header, Toy } from "./toy";

const basin = header<Basin>();
const AGAIN = 90; // ms between two pours of a hand that stays
const NEAR = 0.025; // of the tank's width: so close to the wall a hand takes hold of it
const TOOLS = ["pour", "scoop"] as const;

class Pool extends Toy<Poured> {
  private readonly canvas = element<HTMLCanvasElement>("canvas");
  private readonly picture = new Picture(this.canvas, basin);
  private readonly leaning = document.createElement("input");
  private tool: string = TOOLS[0];
  private hand: { x: number; y: number; holds: boolean } | null = null;

  constructor() {
    super("tank", basin.title, basin.speeds);
    for (const tool of TOOLS) this.choice("tools", tool, () => (this.tool = tool)).setAttribute("aria-checked", String(tool === this.tool));
    for (const [name] of basin.colorings) this.choice("colorings", name, () => void this.act("color", { name }));
    for (const deed of ["open", "close", "wave", "anew"]) element(deed).addEventListener("click", () => void this.act(deed));
    for (const id of ["wave", "push"]) element(id).hidden = !basin.movable;
    this.pointing();
    this.tilting();
    void this.follow();
  }

  protected draw(seen: Poured): void {
    this.picture.draw(seen);
  }

  protected tell(seen: Poured): void {
    const count = seen.colors ? bytes(seen.colors).length : 0;
    element("clock").textContent = `${seen.time.toFixed(1)} s · ${count} particles${this.slow(seen)}`;
    element("open").hidden = !seen.solids.length;
    element("close").hidden = !seen.opened;
    this.scale(seen);
  }

  /** Which colors are on, and how far they reach. */
  private scale({ coloring, most }: Poured): void {
    const [, unit, light, dark] = basin.colorings.find(([name]) => name === coloring)!;
    const coded = window.matchMedia("(prefers-color-scheme: dark)").matches ? dark : light;
    const told = `${Number(most.toPrecision(2))} ${unit}`;
    if (element("most").textContent === told) return;
    element("most").textContent = told;
    for (const button of element("colorings").children) {
      button.setAttribute("aria-checked", String(button.textContent === coloring));
    }
    const [map, image] = [bytes(coded), new ImageData(256, 1)];
    for (let place = 0; place < 256; place++) image.data.set([...map.subarray(3 * place, 3 * place + 3), 255], 4 * place);
    element<HTMLCanvasElement>("bar").getContext("2d")!.putImageData(image, 0, 0);
  }

  private choice(into: string, name: string, chosen: () => void): HTMLButtonElement {
    const button = document.createElement("button");
    button.textContent = name;
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", "false");
    button.addEventListener("click", () => {
      for (const other of element(into).children) other.setAttribute("aria-checked", String(other === button));
      chosen();
    });
    element(into).append(button);
    return button;
  }

  private pointing(): void {
    const { canvas } = this;
    const at = (event: PointerEvent): [number, number] => this.picture.at(event, this.seen?.leaning ?? 0);
    canvas.addEventListener("pointerdown", (event) => {
      const [x, y] = at(event);
      const wall = basin.low[0] + (this.seen?.wall ?? 0);
      const holds = basin.movable && Math.abs(x - wall) < NEAR * (basin.high[0] - basin.low[0]);
      canvas.setPointerCapture(event.pointerId);
      this.hand = { x, y, holds };
      if (holds) return;
      void this.act(this.tool, { x, y });
      this.again();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.hand) return;
      [this.hand.x, this.hand.y] = at(event);
      if (this.hand.holds) void this.act("drag", { x: this.hand.x });
    });
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, () => (this.hand = null));
  }

  /** Pour on while the hand is down. */
  private again(): void {
    const { hand } = this;
    window.setTimeout(() => {
      if (!hand || this.hand !== hand) return;
      void this.act(this.tool, { x: hand.x, y: hand.y });
      this.again();
    }, AGAIN);
  }

  private tilting(): void {
    const { leaning } = this;
    const [row, told] = [document.createElement("label"), document.createElement("output")];
    const most = basin.steepest / DEGREE;
    Object.assign(leaning, { type: "range", min: -most, max: most, step: 0.5, value: 0 });
    leaning.setAttribute("aria-label", "tilt (degrees)");
    const lean = (degrees: number): void => {
      leaning.value = String(degrees);
      told.textContent = `${Number(leaning.value).toFixed(1)}°`;
      void this.act("lean", { angle: Number(leaning.value) * DEGREE });
    };
    leaning.addEventListener("input", () => lean(Number(leaning.value)));
    leaning.addEventListener("dblclick", () => lean(0));
    element("anew").addEventListener("click", () => lean(0));
    const ways: Record<string, number> = { ArrowLeft: -most / 2, ArrowRight: most / 2 };
    this.canvas.addEventListener("keydown", (event) => {
      if (!(event.key in ways)) return;
      event.preventDefault();
      if (!event.repeat) lean(ways[event.key]);
    });
    this.canvas.addEventListener("keyup", (event) => event.key in ways && lean(0));
    row.append("left or right side down", told, leaning);
    element("tilt").append(row);
  }
}

new Pool();
