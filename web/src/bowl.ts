// The page of a bowl: the picture, tools, hands and keys. Where it is simulated, `Asking` says.

import type { Asking, Now } from "./asking";
import { Judge } from "./challenges";
import { ball, millimeters, Picture, type Bowl } from "./dish";
import { Ruler } from "./measuring";
import { apart, nearest, rafts } from "./rafts";
import { choices, element, Toy } from "./toy";

const TOOLS = ["drop", "pour", "take out", "measure"] as const;
const AGAIN = 120; // ms between two floats that are poured
const ARROWS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const LETTERS: Record<string, [number, number]> = { a: [-1, 0], d: [1, 0], w: [0, 1], s: [0, -1] };
const PULL = 12; // radii: how far ahead of a float keys drag it

export abstract class BowlPage extends Toy<Now> {
  protected readonly canvas = element<HTMLCanvasElement>("canvas");
  protected readonly picture: Picture;
  private readonly ruler = new Ruler();
  private readonly judge = new Judge();
  private tool: (typeof TOOLS)[number] = "drop";
  private held = -1;
  private picked = -1;
  private pouring = 0;

  protected constructor(
    protected readonly bowl: Bowl,
    protected chosen: string,
    asking?: Asking,
  ) {
    super("bowl", bowl.title, bowl.speeds, asking);
    this.picture = new Picture(this.canvas, bowl);
    const tools = TOOLS.map((tool) => {
      const button = document.createElement("button");
      button.textContent = tool;
      return button;
    });
    choices(element("tools"), tools, 0, (number) => (this.tool = TOOLS[number]));
    element("anew").addEventListener("click", () => void this.change("anew"));
    this.pointing();
    this.tilting();
    this.keys();
  }

  protected draw(seen: Now): void {
    this.picture.draw(seen);
    const pair = this.ruler.ends(seen);
    if (element<HTMLInputElement>("arrows").checked) this.picture.arrows(seen);
    if (pair) this.picture.ruler(seen, pair);
    for (const one of [this.picked, this.ruler.chosen]) if (one >= 0 && one < seen.x.length) this.picture.ring(seen, one);
    this.ruler.draw(seen, pair);
  }

  protected tell(seen: Now): void {
    const sizes = rafts(seen);
    const several = sizes.filter((size) => size > 1).length;
    const together = several ? `, ${several} ${several > 1 ? "rafts" : "raft"} of up to ${Math.max(...sizes)}` : "";
    element("clock").textContent = `${seen.time.toFixed(1)} s · ${seen.x.length} floats${together}${this.slow(seen)}`;
    element("length").textContent = millimeters(seen.capillary_length);
    const { surface_tension, viscosity, density } = seen.liquid;
    element("liquid-numbers").textContent = `surface tension ${(1e3 * surface_tension).toPrecision(3)} mN/m, viscosity ${(1e3 * viscosity).toPrecision(3)} mPa s, density ${density.toPrecision(4)} kg/m³`;
    this.judge.judge(seen, this.picture.bowl.outline);
  }

  /** Do what gives floats other numbers. */
  protected async change(what: string, more: Record<string, unknown> = {}): Promise<boolean> {
    const done = await this.act(what, more);
    if (done) this.ruler.forget();
    if (done && what !== "drop") this.picked = -1;
    return done;
  }

  /** Buttons for what a press drops. */
  protected shelve(colors: [name: string, color: string][], chosen: () => void): void {
    const buttons = colors.map(([name, color]) => {
      const [button, dot] = [document.createElement("button"), document.createElement("canvas")];
      [dot.width, dot.height] = [32, 32];
      ball(dot.getContext("2d")!, 16, 16, 15, color);
      button.append(dot, name);
      return button;
    });
    const names = colors.map(([name]) => name);
    if (!names.includes(this.chosen)) [this.chosen] = names;
    choices(element("shelf"), buttons, names.indexOf(this.chosen), (number) => {
      this.chosen = names[number];
      chosen();
    });
    chosen();
  }

  private near([x, y]: [number, number]): number {
    const { seen } = this;
    if (!seen) return -1;
    const away = seen.x.map((there, one) => Math.hypot(there - x, seen.y[one] - y) - 1.15 * seen.radius[one]);
    const least = Math.min(...away);
    return least < 0 ? away.indexOf(least) : -1;
  }

  private press(event: PointerEvent): void {
    const [x, y] = this.picture.at(event);
    const one = this.near([x, y]);
    if (this.tool === "take out") void (one >= 0 && this.change("take", { one }));
    else if (this.tool === "measure") this.say(one >= 0 ? this.ruler.choose(one) : "Choose a float.");
    else if (this.tool === "pour" || one < 0) void this.pour(x, y);
    else {
      this.held = one;
      void this.act("grasp", { one, x, y });
    }
  }

  /** One float, and with that tool more of them as long as the press lasts. */
  private async pour(x: number, y: number): Promise<void> {
    const number = ++this.pouring;
    const pours = this.tool === "pour";
    while (number === this.pouring && (await this.act("drop", { name: this.chosen, x, y })) && pours) {
      await new Promise((resolve) => setTimeout(resolve, AGAIN));
    }
  }

  private pointing(): void {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => {
      if (!event.isPrimary) return;
      canvas.setPointerCapture(event.pointerId);
      this.press(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.held < 0 || !event.isPrimary) return;
      const [x, y] = this.picture.at(event);
      void this.act("grasp", { one: this.held, x, y });
    });
    const release = (event: PointerEvent): void => {
      if (!event.isPrimary) return;
      this.pouring++;
      if (this.held >= 0) void this.act("release");
      this.held = -1;
    };
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, release);
    canvas.addEventListener("dblclick", (event) => {
      const one = this.near(this.picture.at(event));
      if (one >= 0 && this.tool === "drop") void this.change("take", { one });
    });
  }

  private tilting(): void {
    const [pad, level] = [element("pad"), element("level")];
    const lean = (across: number, up: number): void => {
      const far = Math.max(1, Math.hypot(across, up));
      const [x, y] = [across / far, up / far];
      level.style.transform = `translate(${2.8 * x}rem, ${-2.8 * y}rem)`;
      void this.act("tilt", { x: this.bowl.steepest * x, y: this.bowl.steepest * y });
    };
    const drag = (event: PointerEvent): void => {
      const box = pad.getBoundingClientRect();
      lean((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    };
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      drag(event);
    });
    pad.addEventListener("pointermove", (event) => event.buttons && drag(event));
    for (const end of ["pointerup", "pointercancel"] as const) pad.addEventListener(end, () => lean(0, 0));
    for (const on of [this.canvas, pad]) {
      on.addEventListener("keydown", (event) => {
        if (!(event.key in ARROWS)) return;
        event.preventDefault();
        if (!event.repeat) lean(...ARROWS[event.key]);
      });
      on.addEventListener("keyup", (event) => event.key in ARROWS && lean(0, 0));
    }
  }

  /** All that hands do, by keys. */
  private keys(): void {
    this.canvas.addEventListener("keydown", (event) => {
      const { seen, picked } = this;
      const key = event.key.toLowerCase();
      if (!seen || event.ctrlKey || event.metaKey || event.altKey) return;
      const there = picked >= 0 && picked < seen.x.length;
      if (key === "n" && seen.x.length) this.pick((picked + (event.shiftKey ? seen.x.length - 1 : 1)) % seen.x.length, seen);
      else if (key === "i") this.hear(this.described(seen));
      else if ((key === "x" || key === "r" || key in LETTERS) && !there) this.hear("Choose a float first, with N.");
      else if (key === "x") void this.change("take", { one: picked }).then((done) => done && this.hear(`Taken out: ${seen.x.length - 1} floats.`));
      else if (key === "r") this.hear(this.ruler.choose(picked) || this.measured(seen));
      else if (key === "enter") void this.act("drop", { name: this.chosen, x: 0, y: 0 }).then((done) => done && this.hear(`Dropped a ${this.chosen} near the middle: ${seen.x.length + 1} floats.`));
      else if (key in LETTERS) {
        const [x, y] = LETTERS[key].map((way, axis) => (axis ? seen.y : seen.x)[picked] + PULL * seen.radius[picked] * way);
        void this.act("grasp", { one: picked, x, y });
      } else return;
      event.preventDefault();
    });
    this.canvas.addEventListener("keyup", (event) => event.key.toLowerCase() in LETTERS && void this.act("release"));
  }

  private measured(seen: Now): string {
    const pair = this.ruler.ends(seen);
    return pair ? `${millimeters(apart(seen, ...pair))} apart; the distance over time is beside the bowl.` : "";
  }

  private pick(one: number, seen: Now): void {
    this.picked = one;
    const others = seen.x.map((_, other) => (other === one ? Infinity : apart(seen, one, other)));
    const near = others.length > 1 ? `, ${millimeters(Math.min(...others))} from the nearest` : "";
    const [x, y] = [seen.x[one], seen.y[one]];
    const where = `${millimeters(Math.abs(x))} ${x < 0 ? "left" : "right"} and ${millimeters(Math.abs(y))} ${y < 0 ? "below" : "above"} the middle`;
    this.hear(`${seen.kinds[seen.species[one]].name}, ${one + 1} of ${seen.x.length}, ${where}${near}`);
  }

  private described(seen: Now): string {
    const pair = nearest(seen, true);
    const near = pair ? `; the nearest two that do not touch are ${millimeters(apart(seen, ...pair))} apart` : "";
    return `${element("clock").textContent}${near}`;
  }

  /** For those who do not see the picture. */
  private hear(text: string): void {
    element("heard").textContent = text;
  }
}
