// A bowl to play with: what hands do here is simulated by the program that gave out this page.

import type { Now } from "./asking";
import { BowlPage } from "./bowl";
import { DEGREE, element, header } from "./toy";
import type { Bowl } from "./dish";

const bowl = header<Bowl>();

class Play extends BowlPage {
  private listed = "";
  private sliders = new Map<string, HTMLInputElement>();

  constructor() {
    super(bowl, bowl.shelf[0].name);
    const liquid = element("numbers");
    this.slider(liquid, "surface tension", "liquid", "surface_tension", [10, 80], 1e-3, "mN/m");
    this.slider(liquid, "viscosity", "liquid", "viscosity", [0.5, 50], 1e-3, "mPa s");
    void this.follow();
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
    this.shelve(names.map((name) => [name, colors.get(name)!]));
    const angles = element("angles");
    for (const old of [...angles.querySelectorAll("label")]) old.remove();
    this.slider(angles, "dish", "dish", "contact_angle", [10, 170], DEGREE, "°");
    for (const kind of kinds) {
      if (kind.contact_angle !== null) this.slider(angles, kind.name, kind.name, "contact_angle", [5, 175], DEGREE, "°");
    }
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

}

new Play();