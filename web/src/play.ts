// A bowl to play with: what hands do here is simulated by the program that gave out this page.

import type { Now } from "./asking";
import { ball, Picture, type Bowl } from "./dish";
import { DEGREE, element, header, Toy } from "./toy";

const bowl = header<Bowl>();

class Play extends Toy<Now> {
  private readonly canvas = element<HTMLCanvasElement>("canvas");
  private readonly picture = new Picture(this.canvas, bowl);
  private chosen = bowl.shelf[0].name;
  private held = -1;
  private listed = "";
  private sliders = new Map<string, HTMLInputElement>();

  constructor() {
    super("bowl", bowl.title, bowl.speeds);
    this.pointing();
    this.tilting();
    const liquid = element("numbers");
    this.slider(liquid, "surface tension", "liquid", "surface_tension", [10, 80], 1e-3, "mN/m");
    this.slider(liquid, "viscosity", "liquid", "viscosity", [0.5, 50], 1e-3, "mPa s");
    void this.follow();
  }

  protected draw(seen: Now): void {
    this.picture.draw(seen);
  }

  protected tell(seen: Now): void {
    this.list(seen);
    const { time, x, clusters, liquid, dish, kinds } = seen;
    element("clock").textContent = `${time.toFixed(1)} s · ${x.length} floats, ${clusters} clusters${this.slow(seen)}`;
    const told: [string, number][] = Object.entries(liquid).map(([key, value]) => [`liquid.${key}`, value]);
    told.push(["dish.contact_angle", dish.contact_angle]);
    for (const kind of kinds) if (kind.contact_angle !== null) told.push([`${kind.name}.contact_angle`, kind.contact_angle]);
    for (const [name, value] of told) this.show(name, value);
  }

  /** Buttons and sliders for the species there are. */
  private list({ kinds }: Now): void {
    const names = [...new Set([...kinds.map((kind) => kind.name), ...bowl.shelf.map((kind) => kind.name)])];
    if (names.join("\n") + kinds.length === this.listed) return;
    this.listed = names.join("\n") + kinds.length;
    const colors = new Map([...bowl.shelf, ...kinds].map((kind) => [kind.name, kind.color]));
    element("shelf").replaceChildren(...names.map((name) => this.choice(name, colors.get(name)!)));
    const angles = element("angles");
    for (const old of [...angles.querySelectorAll("label")]) old.remove();
    this.slider(angles, "dish", "dish", "contact_angle", [10, 170], DEGREE, "°");
    for (const kind of kinds) {
      if (kind.contact_angle !== null) this.slider(angles, kind.name, kind.name, "contact_angle", [5, 175], DEGREE, "°");
    }
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

  private slider(into: HTMLElement, label: string, part: string, key: string, [low, high]: [number, number], unit: number, name: string): void {
    const [row, input, told] = [document.createElement("label"), document.createElement("input"), document.createElement("output")];
    Object.assign(input, { type: "range", min: low, max: high, step: (high - low) / 200 });
    input.dataset.unit = String(unit);
    input.dataset.name = name;
    input.setAttribute("aria-label", `${label} (${name})`);
    input.addEventListener("change", () => void this.act("change", { part, key, value: Number(input.value) * unit }));
    input.addEventListener("input", () => (told.textContent = `${Number(input.value).toPrecision(3)} ${name}`));
    row.append(label, told, input);
    into.append(row);
    this.sliders.set(`${part}.${key}`, input);
  }

  /** What a slider stands at, unless a hand is on it. */
  private show(name: string, value: number): void {
    const input = this.sliders.get(name);
    if (!input || document.activeElement === input) return;
    const plain = value / Number(input.dataset.unit);
    input.value = String(plain);
    input.previousElementSibling!.textContent = `${Number(plain.toPrecision(3))} ${input.dataset.name}`;
  }

  private near([x, y]: [number, number]): number {
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
      void this.act("tilt", { x: bowl.steepest * x, y: bowl.steepest * y });
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

new Play();
