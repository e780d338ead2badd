// A bowl to play with, simulated in the page or by the program that gave it out.

import type { Now } from "./asking";
import { BowlPage } from "./bowl";
import type { Alone, Chapter, Filled } from "./chapters";
import type { Bowl } from "./dish";
import { begun, beginning, type Inside } from "./inside";
import { offerLinks } from "./sharing";
import { DEGREE, element, header, slider } from "./toy";

type Range = [label: string, part: string, key: string, low: number, high: number, unit: number, name: string];

function rounded(value: number): number {
  return Number(value.toPrecision(3));
}

/** A bowl that a program simulates: all numbers can be changed. */
class Served extends BowlPage {
  private listed = "";
  private numbers = "";

  constructor(private readonly told: Bowl) {
    super(told, told.shelf[0].name);
    for (const name of ["link", "chapters", "empty", "liquid", "shape"]) element(name).hidden = true;
    void this.follow();
  }

  protected tell(seen: Now): void {
    super.tell(seen);
    this.list(seen);
    const { kinds, liquid, dish } = seen;
    const numbers = JSON.stringify([kinds, liquid, dish]);
    const inUse = document.activeElement?.matches("#factors input, #liquid-sliders input");
    const stale = !inUse && numbers !== this.numbers;
    this.numbers = inUse ? "" : numbers; // a slider in use stays, and all are made again after it
    if (!stale) return;
    this.offer();
    element("liquid-sliders").replaceChildren(
      this.range(["surface tension", "liquid", "surface_tension", 10, 80, 1e-3, "mN/m"], liquid.surface_tension),
      this.range(["viscosity", "liquid", "viscosity", 0.5, 50, 1e-3, "mPa s"], liquid.viscosity),
      this.range(["contact angle", "dish", "contact_angle", 10, 170, DEGREE, "°"], dish.contact_angle),
    );
  }

  /** What can be dropped. */
  private list(seen: Now): void {
    const colors = new Map([...seen.kinds, ...this.told.shelf, ...seen.kinds].map(({ name, color }) => [name, color]));
    const listed = [...colors.keys()].join("\n");
    if (listed !== this.listed) this.shelve([...colors], () => this.offer());
    this.listed = listed;
  }

  /** Sliders for the chosen species, if there is one of it. */
  private offer(): void {
    const kind = this.seen?.kinds.find(({ name }) => name === this.chosen);
    const { name = "", radius = 0, density = 0, contact_angle = null } = kind ?? {};
    const rows = [
      this.range(["radius", name, "radius", 0.5, 4, 1e-3, "mm"], radius),
      this.range(["density", name, "density", 20, 3000, 1, "kg/m³"], density),
      ...(contact_angle === null ? [] : [this.range(["contact angle", name, "contact_angle", 5, 175, DEGREE, "°"], contact_angle)]),
    ];
    element("factors").replaceChildren(...(kind ? rows : []));
  }

  private range([label, part, key, min, max, unit, name]: Range, value: number): HTMLLabelElement {
    const range = { min, max, step: (max - min) / 200, value: value / unit };
    return slider(label, part, range, (now) => `${rounded(now)} ${name}`, (now) => this.act("change", { part, key, value: now * unit }));
  }
}

const FACTORS: Record<string, (factor: number) => string> = {
  size: (factor) => `${factor} × radius`,
  density: (factor) => `${factor} × density`,
  "contact angle": (more) => (more ? `${more > 0 ? "+" : "−"}${Math.abs(more)}°` : "as it is"),
};

/** A bowl that the page simulates: kinds, liquids and dishes whose numbers stand in the page. */
class Alike extends BowlPage {
  private shown = "";

  constructor(
    inside: Inside,
    private readonly alone: Alone,
    private readonly liquids: Record<string, Filled>[],
  ) {
    const { title, species, dishes } = alone.chapters[0];
    const bowl: Bowl = { ...alone, title, ...Object.values(dishes)[0], grid: 1, shelf: species, map: "" };
    super(bowl, species[0].name, inside);
    const chapters = element<HTMLSelectElement>("chapter");
    chapters.append(...alone.chapters.map((chapter) => new Option(chapter.title)));
    chapters.addEventListener("change", () => void this.change("anew", { chapter: chapters.selectedIndex }));
    for (const name of ["liquid", "dish"]) {
      const select = element<HTMLSelectElement>(`${name}-name`);
      select.addEventListener("change", async () => {
        if (!(await this.act(name, { name: select.value }))) this.shown = "";
      });
    }
    element("empty").addEventListener("click", () => void this.change("empty"));
    void offerLinks(inside, "bowl", (text) => this.say(text), (fragment) => this.change("bring", { fragment })).then(() => this.follow());
  }

  private get chapter(): Chapter {
    return this.alone.chapters[this.seen?.choice?.chapter ?? 0];
  }

  protected draw(seen: Now): void {
    const shown = JSON.stringify(seen.choice);
    if (shown !== this.shown) this.choose(seen.choice!);
    this.shown = shown;
    super.draw(seen);
  }

  /** What is chosen now: another chapter, liquid or dish. */
  private choose({ chapter, liquid, dish }: NonNullable<Now["choice"]>): void {
    const { title, species, dishes } = this.alone.chapters[chapter];
    this.picture.bowl = { ...dishes[dish], grid: 1, map: "" };
    element("title").textContent = document.title = title;
    element<HTMLSelectElement>("chapter").selectedIndex = chapter;
    const offered = { liquid: [Object.keys(this.liquids[chapter]), liquid], dish: [Object.keys(dishes), dish] } as const;
    for (const [name, [names, chosen]] of Object.entries(offered)) {
      const select = element<HTMLSelectElement>(`${name}-name`);
      select.replaceChildren(...names.map((one) => new Option(one)));
      select.value = chosen;
      select.disabled = names.length < 2;
    }
    this.shelve(species.map(({ name, color }) => [name, color]), () => this.offer());
  }

  /** Sliders for the kind of the chosen species. */
  private offer(): void {
    const { species, factors } = this.chapter;
    const number = species.findIndex(({ name }) => name === this.chosen);
    const rows = Object.entries(factors).map(([name, each], factor) => {
      const value = this.seen?.choice?.choices[number][factor] ?? this.chapter.usual[factor];
      const range = { min: 0, max: each.length - 1, step: 1, value };
      return slider(name, this.chosen, range, (place) => FACTORS[name](each[place]), (place) => this.act("kind", { species: number, factor, value: place }));
    });
    const had = document.activeElement?.getAttribute("aria-label");
    element("factors").replaceChildren(...rows);
    if (had) element("factors").querySelector<HTMLElement>(`[aria-label="${CSS.escape(had)}"]`)?.focus();
  }
}

async function begin(): Promise<void> {
  if (!element("wasm")) return void new Served(header<Bowl>());
  const alone = header<Alone>();
  const [inside, liquids] = await begun<Record<string, Filled>[]>("liquids", { alone });
  new Alike(inside, alone, liquids);
}

beginning(begin);
