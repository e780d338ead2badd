// A tank to play with, simulated in the page or by the program that gave it out.

import type { Asking, Poured } from "./asking";
import { type Basin, FINEST, Picture, words } from "./basin";
import { begun, beginning, Inside } from "./inside";
import { offerLinks } from "./sharing";
import { bytes, choices, DEGREE, element, header, paintBar, themed, Toy } from "./toy";

const basin = header<Basin>();
const AGAIN = 90; // ms between two pours of a hand that stays
const NEAR = 0.025; // of the tank's width: so close to the wall a hand takes hold of it
const TOOLS = ["pour", "scoop"] as const;
const STRIDE = 0.02; // of the tank's width, by which a key moves the mark
const MOVES: Record<string, [number, number]> = { a: [-1, 0], d: [1, 0], w: [0, 1], s: [0, -1] };

const PUSHES: Record<string, number> = { e: 1, q: -1 };

function named(text: string): HTMLButtonElement {
  const button = document.createElement("button");
  button.textContent = text;
  return button;
}

class Pool extends Toy<Poured> {
  private readonly canvas = element<HTMLCanvasElement>("canvas");
  private readonly picture = new Picture(this.canvas, basin);
  private readonly leaning = document.createElement("input");
  private readonly told = document.createElement("output");
  private leans = 0; // that were asked and not answered
  private tool: string = TOOLS[0];
  private cursor: [number, number] = [(basin.low[0] + basin.high[0]) / 2, 0.8 * basin.high[1]];
  private marked = false;
  private hand: { x: number; y: number; holds: boolean } | null = null;

  constructor(asking?: Asking) {
    super("tank", basin.title, basin.speeds, asking);
    choices(element("tools"), TOOLS.map((tool) => named(tool)), 0, (number) => (this.tool = TOOLS[number]));
    const colorings = basin.colorings.map(([name]) => name);
    choices(element("colorings"), colorings.map(named), 0, (number) => void this.act("color", { name: colorings[number] }));
    for (const deed of ["open", "close", "wave", "anew"]) element(deed).addEventListener("click", () => void this.act(deed));
    for (const id of ["wave", "push"]) element(id).hidden = !basin.movable;
    this.pointing();
    this.tilting();
    const linked = asking instanceof Inside;
    element("link").hidden = !linked;
    void (linked ? offerLinks(asking, "tank", (text) => this.say(text), (fragment) => this.act("bring", { fragment })) : Promise.resolve()).then(() => this.follow());
  }

  protected draw(seen: Poured): void {
    this.picture.draw(seen);
    if (this.marked && document.activeElement === this.canvas) this.picture.cross(this.cursor);
  }

  protected tell(seen: Poured): void {
    const count = seen.colors ? bytes(seen.colors).length : 0;
    element("clock").textContent = `${seen.time.toFixed(1)} s · ${count} particles${this.slow(seen)}`;
    element("open").hidden = !seen.solids.length;
    element("close").hidden = !seen.opened;
    if (!this.leans) this.tiltedBy(seen.tilt / DEGREE);
    this.scale(seen);
  }

  /** Which colors are on, and how far they reach. */
  private scale({ coloring, most }: Poured): void {
    const [, unit, light, dark] = basin.colorings.find(([name]) => name === coloring)!;
    const told = `${Number(most.toPrecision(2))} ${unit}`;
    if (element("most").textContent === told) return;
    element("most").textContent = told;
    paintBar(bytes(themed([light, dark])));
  }

  private pointing(): void {
    const { canvas } = this;
    const at = (event: PointerEvent): [number, number] => this.picture.at(event, this.seen?.leaning ?? 0);
    canvas.addEventListener("pointerdown", (event) => {
      if (!event.isPrimary) return;
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
      if (!this.hand || !event.isPrimary) return;
      [this.hand.x, this.hand.y] = at(event);
      if (this.hand.holds) void this.act("drag", { x: this.hand.x });
    });
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, (event) => event.isPrimary && (this.hand = null));
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

  /** Keys that move a mark in the tank, pour or scoop there, and tell how things stand. */
  private pressed(event: KeyboardEvent): void {
    const key = event.key.toLowerCase();
    const { low, high } = basin;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (key in MOVES) {
      const stride = STRIDE * (high[0] - low[0]);
      this.cursor = this.cursor.map((x, axis) => Math.min(Math.max(x + stride * MOVES[key][axis], low[axis]), high[axis])) as [number, number];
      this.marked = true;
      this.hear(`The mark is at ${this.cursor.map((x) => x.toFixed(2)).join(", ")} m.`);
    } else if (key in PUSHES && basin.movable) {
      const stride = STRIDE * (high[0] - low[0]);
      void this.act("drag", { x: low[0] + (this.seen?.wall ?? 0) + PUSHES[key] * 4 * stride });
    } else if (key === "enter") void this.act(this.tool, { x: this.cursor[0], y: this.cursor[1] }).then((done) => done && this.hear(this.tool === "pour" ? "Poured." : "Scooped."));
    else if (key === "i") this.hear(this.stands());
    else return;
    event.preventDefault();
  }

  /** For those who do not see the picture. */
  private hear(text: string): void {
    element("heard").textContent = text;
  }

  /** How things stand, in words. */
  private stands(): string {
    if (!this.seen) return "";
    const { time, coloring, most, places, colors, opened, solids, leaning } = this.seen;
    const [place, shade] = [words(places), bytes(colors)];
    const height = basin.view[3] - basin.view[1];
    let [highest, strongest] = [0, 0];
    shade.forEach((value, one) => [highest, strongest] = [Math.max(highest, place[2 * one + 1]), Math.max(strongest, value)]);
    const gates = opened ? `${opened} open` : solids.length ? "closed" : "none";
    const [unit] = basin.colorings.filter(([name]) => name === coloring).map(([, each]) => each);
    return `After ${time.toFixed(1)} seconds: ${shade.length} particles; the highest is ${((highest / FINEST) * height).toFixed(2)} m above the bottom, ` +
      `the largest ${coloring} is ${((most * strongest) / 255).toPrecision(2)} ${unit}. Gates: ${gates}. Tilt: ${(leaning / DEGREE).toFixed(0)} degrees. ` +
      `The mark is at ${this.cursor.map((x) => x.toFixed(2)).join(", ")} m.`;
  }

  /** The slider of the tilt follows a tank that was tilted otherwise: it stands upright when it begins again. */
  private tiltedBy(degrees: number): void {
    if (Math.abs(Number(this.leaning.value) - degrees) > 0.01) this.leaning.value = String(degrees);
    this.told.textContent = `${Number(this.leaning.value).toFixed(1)}°`;
  }

  private tilting(): void {
    const { leaning, told } = this;
    const row = document.createElement("label");
    const most = basin.steepest / DEGREE;
    Object.assign(leaning, { type: "range", min: -most, max: most, step: 0.5, value: 0 });
    leaning.setAttribute("aria-label", "tilt (degrees)");
    const lean = async (degrees: number): Promise<void> => {
      leaning.value = String(degrees);
      this.tiltedBy(Number(leaning.value));
      this.leans++;
      const leans = await this.act("lean", { angle: Number(leaning.value) * DEGREE });
      this.leans--;
      if (!leans && !this.leans && this.seen) this.tiltedBy(this.seen.tilt / DEGREE);
    };
    leaning.addEventListener("input", () => void lean(Number(leaning.value)));
    leaning.addEventListener("dblclick", () => void lean(0));
    const ways: Record<string, number> = { ArrowLeft: -most / 2, ArrowRight: most / 2 };
    this.canvas.addEventListener("keydown", (event) => {
      this.pressed(event);
      if (!(event.key in ways)) return;
      event.preventDefault();
      if (!event.repeat) void lean(ways[event.key]);
    });
    this.canvas.addEventListener("keyup", (event) => event.key in ways && void lean(0));
    row.append("left or right side down", told, leaning);
    element("tilt").append(row);
  }
}

beginning(async () => {
  if (element("wasm")) new Pool((await begun("cases"))[0]);
  else new Pool();
});
