// What the pages of a bowl share: the picture, what lies on the shelf, and hands.

import type { Asking, Now } from "./asking";
import { ball, Picture, type Bowl } from "./dish";
import { element, Toy } from "./toy";

export abstract class BowlPage extends Toy<Now> {
  protected readonly canvas = element<HTMLCanvasElement>("canvas");
  protected readonly picture: Picture;
  private held = -1;

  protected constructor(
    protected readonly bowl: Bowl,
    protected chosen: string,
    asking?: Asking,
  ) {
    super("bowl", bowl.title, bowl.speeds, asking);
    this.picture = new Picture(this.canvas, bowl);
    this.pointing();
    this.tilting();
  }

  protected draw(seen: Now): void {
    this.picture.draw(seen);
  }

  /** Buttons for what a click drops. */
  protected shelve(colors: [name: string, color: string][]): void {
    element("shelf").replaceChildren(...colors.map(([name, color]) => this.choice(name, color)));
  }

  private choice(name: string, color: string): HTMLButtonElement {
    const button = document.createElement("button");
    const dot = document.createElement("canvas");
    [dot.width, dot.height] = [32, 32];
    ball(dot.getContext("2d")!, 16, 16, 15, color);
    button.append(dot, name);
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", String(name === this.chosen));
    button.addEventListener("click", () => {
      this.chosen = name;
      for (const other of element("shelf").children) other.setAttribute("aria-checked", String(other === button));
    });
    return button;
  }

  protected near([x, y]: [number, number]): number {
    const { seen } = this;
    if (!seen) return -1;
    return seen.x.findIndex((there, one) => Math.hypot(there - x, seen.y[one] - y) < 1.15 * seen.radius[one]);
  }

  private pointing(): void {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => {
      const [x, y] = this.picture.at(event);
      this.held = this.near([x, y]);
      if (this.held < 0) void this.act("drop", { name: this.chosen, x, y });
      else {
        canvas.setPointerCapture(event.pointerId);
        void this.act("grasp", { one: this.held, x, y });
      }
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.held < 0) return;
      const [x, y] = this.picture.at(event);
      void this.act("grasp", { one: this.held, x, y });
    });
    const release = (): void => {
      if (this.held >= 0) void this.act("release");
      this.held = -1;
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("dblclick", (event) => {
      const one = this.near(this.picture.at(event));
      if (one >= 0) void this.act("take", { one });
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
    const ways: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    this.canvas.addEventListener("keydown", (event) => {
      if (!(event.key in ways)) return;
      event.preventDefault();
      if (!event.repeat) lean(...ways[event.key]);
    });
    this.canvas.addEventListener("keyup", (event) => event.key in ways && lean(0, 0));
  }
}
