// The bowl that a page simulates by itself, in a worker: floats as hands and sliders leave them, and ecume's compiled steps.

import { Memory, type Compiled, type Slot } from "./memory";
import type { Now } from "./asking";

/** What the page knows of the scene; see ecume.show.play.alone. */
export interface Alone {
  title: string;
  outline: [number, number][];
  view: [number, number, number, number];
  steepest: number;
  fastest: number;
  grasp: number;
  room: number;
  own: [number, number]; // the current of the scene itself (m/s)
  species: { name: string; color: string; radius: number }[];
  factors: Record<string, number[]>;
  usual: number[]; // the choice of factors that leaves a species as it is
  floats: [species: number, x: number, y: number, vx: number, vy: number][];
}

/** All that depends on the liquid. */
export interface Filled {
  liquid: Record<string, number>;
  capillary_length: number;
  color: string | null;
  swing: number; // rad/s
  current: number; // s^2: velocity of the liquid over the rate of its slope times gravity
  slots: Slot[];
  kinds: Record<string, (number | null)[]>;
  steps: { time: number; decay: number[]; gain: number[]; mobility: number[] }[];
  toml: string;
}

/** What a link or a reload brings back. */
export interface Kept {
  liquid: string;
  choices: number[][];
  floats: [species: number, x: number, y: number, vx: number, vy: number][];
}

const LONGEST = 0.1; // s of simulated time at once
const BUDGET = 14; // ms of the clock between two pictures
const ROOMY = 1.02; // how far apart centers must be for a new float, in sums of radii
const TOUCHING = 1.03; // of one raft, in sums of radii

export class Bowl {
  private memory!: Memory;
  private floats: Kept["floats"];
  private choices: number[][];
  private liquid = "as given";
  private hand: { one: number; x: number; y: number } | null = null;
  private tilt: [number, number] = [0, 0];
  private slope: [number, number] = [0, 0];
  private rate: [number, number] = [0, 0];
  private time = 0;
  private last = 0;
  private speed = 1;
  private pace = 1;
  private step = 0;
  private news: string[] = [];

  constructor(
    private readonly compiled: Compiled,
    private readonly alone: Alone,
    private readonly liquids: Record<string, Filled>,
  ) {
    this.floats = alone.floats;
    this.choices = alone.species.map(() => [...alone.usual]);
    this.begin();
  }

  /** The number of a species' kind among all that the page offers. */
  private kind(species: number): number {
    const [sizes, densities, angles] = Object.values(this.alone.factors).map((each) => each.length);
    const [size, density, angle] = this.choices[species];
    return ((species * sizes + size) * densities + density) * angles + angle;
  }

  private get filled(): Filled {
    return this.liquids[this.liquid];
  }

  private of(name: string, species: number): number | null {
    return this.filled.kinds[name][this.kind(species)];
  }

  /** Go on with the floats as they are kept, in the liquid and of the kinds that are chosen. */
  private begin(): void {
    const { filled, floats, compiled } = this;
    const kinds = floats.map(([species]) => this.kind(species));
    const usual = this.choices.every((choice) => choice.every((one, k) => one === this.alone.usual[k])) ? 0 : 1;
    const { time, decay, gain, mobility } = filled.steps[usual];
    const memory = new Memory(compiled, filled.slots, floats.length);
    for (const [name, values] of Object.entries(filled.kinds)) {
      if (!name.startsWith("wall ")) memory.put(`parameters.floats.${name}`, kinds.map((kind) => values[kind]!));
    }
    const walls = Object.keys(filled.kinds).filter((name) => name.startsWith("wall "));
    memory.put("parameters.wall_strength", walls.flatMap((name) => kinds.map((kind) => filled.kinds[name][kind]!)));
    memory.put("parameters.floats.species", floats.map(([species]) => species));
    memory.put("parameters.time_step", [time]);
    memory.put("parameters.kick.decay", kinds.map((kind) => decay[kind]));
    memory.put("parameters.kick.gain", kinds.map((kind) => gain[kind]));
    memory.put("parameters.kick.mobility", kinds.map((kind) => mobility[kind]));
    const places = floats.flatMap(([, x, y]) => [x, y]);
    memory.put("state.position", places);
    memory.put("state.reference", places);
    memory.put("state.velocity", floats.flatMap(([, , , vx, vy]) => [vx, vy]));
    [this.memory, this.step, this.hand] = [memory, time, null];
    if (floats.length && !memory.renew()) throw new Error("There is no room for so many neighbors.");
  }

  /** Read the floats back. */
  private keep(): void {
    if (!this.floats.length) return;
    const [place, speed] = [this.memory.numbersOf("state.position"), this.memory.numbersOf("state.velocity")];
    this.floats = this.floats.map(([species], k) => [species, place[2 * k], place[2 * k + 1], speed[2 * k], speed[2 * k + 1]]);
  }

  /** Take so many steps; whatever diverges is brought to rest where it was. */
  go(steps: number): void {
    this.keep();
    const { filled, memory } = this;
    const seconds = steps * this.step;
    for (const axis of [0, 1]) {
      [this.slope[axis], this.rate[axis]] = memory.swing(this.slope[axis], this.rate[axis], this.tilt[axis], filled.swing, seconds);
    }
    memory.put("parameters.drift.flow", this.alone.own.map((own, axis) => own + filled.current * this.rate[axis]));
    if (this.hand) this.drag(this.hand);
    if (this.floats.length && memory.advance(steps) !== 0) {
      this.floats = this.floats.map(([species, x, y]) => [species, x, y, 0, 0]);
      this.news.push("The floats went too fast for their time step: they were brought to rest where they were.");
      this.begin();
    }
    this.time += seconds;
  }

  private drag({ one, x, y }: { one: number; x: number; y: number }): void {
    const place = this.memory.numbersOf("state.position");
    const [along, up] = [(x - place[2 * one]) / this.alone.grasp, (y - place[2 * one + 1]) / this.alone.grasp];
    const share = Math.min(1, this.alone.fastest / Math.max(Math.hypot(along, up), 1e-300));
    this.memory.numbersOf("state.velocity").set([along * share, up * share], 2 * one);
  }

  /** As far as the clock has gone, or as far as there is time for. */
  private follow(): void {
    const now = performance.now();
    const due = Math.min(LONGEST, (this.speed * (now - (this.last || now))) / 1000);
    this.last = now;
    let left = Math.round(due / this.step);
    const asked = left;
    while (left > 0 && performance.now() - now < BUDGET) {
      const some = Math.min(left, 8);
      this.go(some);
      left -= some;
    }
    if (asked > 0) this.pace += 0.1 * ((asked - left) / asked - this.pace);
  }

  now(): Now & { force: number[]; largest: number; steady: number } {
    this.follow();
    this.keep();
    const { filled, floats, alone } = this;
    const rafts = this.rafts();
    return {
      time: this.time,
      speed: this.speed,
      pace: this.pace,
      news: this.news,
      x: floats.map(([, x]) => x),
      y: floats.map(([, , y]) => y),
      radius: floats.map(([species]) => this.of("radius", species)!),
      species: floats.map(([species]) => species),
      kinds: alone.species.map(({ name, color }, species) => ({
        name,
        color,
        contact_angle: this.of("contact_angle", species),
        density: this.of("density", species) ?? 0,
      })),
      clusters: rafts.length,
      tilt: this.tilt,
      slope: this.slope,
      liquid: filled.liquid,
      dish: {},
      surface: "",
      highest: 0,
      color: filled.color,
      force: floats.length ? [...this.memory.numbersOf("workspace.force")] : [],
      largest: Math.max(0, ...rafts),
      steady: this.step,
    };
  }

  /** The sizes of all rafts. */
  private rafts(): number[] {
    const { floats } = this;
    const raft = floats.map((_, one) => one);
    const root = (one: number): number => (raft[one] === one ? one : (raft[one] = root(raft[one])));
    for (let one = 0; one < floats.length; one++) {
      for (let other = 0; other < one; other++) {
        const near = TOUCHING * (this.of("radius", floats[one][0])! + this.of("radius", floats[other][0])!);
        if (Math.hypot(floats[one][1] - floats[other][1], floats[one][2] - floats[other][2]) < near) raft[root(one)] = root(other);
      }
    }
    const sizes = new Map<number, number>();
    floats.forEach((_, one) => sizes.set(root(one), (sizes.get(root(one)) ?? 0) + 1));
    return [...sizes.values()];
  }

  /** Do something; why it was not done, or nothing. */
  act(what: string, asked: Record<string, unknown>): string {
    const [x, y, one] = [Number(asked.x), Number(asked.y), Number(asked.one)];
    const there = Number.isInteger(one) && one >= 0 && one < this.floats.length;
    this.keep();
    if (what === "speed") this.speed = Number(asked.value);
    else if (what === "tilt") this.tilt = [x, y];
    else if (what === "release") this.hand = null;
    else if (what === "grasp" && there) this.hand = { one, x, y };
    else if (what === "drop") return this.drop(this.alone.species.findIndex(({ name }) => name === asked.name), x, y);
    else if (what === "take" && there) {
      this.floats = this.floats.filter((_, other) => other !== one);
      this.begin();
    } else if (what === "liquid") return this.changed(() => (this.liquid = String(asked.name)), String(asked.name) in this.liquids);
    else if (what === "kind") {
      const [species, factor, value] = [Number(asked.species), Number(asked.factor), Number(asked.value)];
      return this.changed(() => (this.choices[species][factor] = value), true);
    } else if (what === "keep") return JSON.stringify(this.kept());
    else if (what === "bring") return this.bring(asked.kept as Kept);
    else return "That cannot be done.";
    return "";
  }

  /** Try a change of liquid or kinds; nothing changes where a float would sink or overlap another. */
  private changed(change: () => void, known: boolean): string {
    if (!known) return "There is no such liquid.";
    const [liquid, choices] = [this.liquid, this.choices.map((choice) => [...choice])];
    change();
    const fault = this.fault(this.floats);
    if (fault) [this.liquid, this.choices] = [liquid, choices];
    this.begin();
    return fault;
  }

  /** Why the floats cannot be there. */
  private fault(floats: Kept["floats"]): string {
    for (const [k, [species, x, y]] of floats.entries()) {
      const radius = this.of("radius", species);
      if (radius === null) return `A ${this.alone.species[species].name} of this kind sinks in this liquid.`;
      if (this.beyond(x, y, 0.97 * radius)) return "A float would reach beyond the wall.";
      for (const [other, right, up] of floats.slice(0, k)) {
        const apart = radius + (this.of("radius", other) ?? 0);
        if (Math.hypot(x - right, y - up) < 0.98 * apart) return "Floats would overlap: move them apart first.";
      }
    }
    return "";
  }

  private beyond(x: number, y: number, radius: number): boolean {
    const { outline } = this.alone;
    return outline.some(([ax, ay], k) => {
      const [bx, by] = outline[(k + 1) % outline.length];
      return ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / Math.hypot(bx - ax, by - ay) < radius;
    });
  }

  private drop(species: number, x: number, y: number): string {
    if (species < 0) return "There is no such species.";
    if (this.floats.length >= this.alone.room) return `A page has room for ${this.alone.room} floats.`;
    const radius = this.of("radius", species);
    if (radius === null) return `A ${this.alone.species[species].name} of this kind sinks in this liquid.`;
    const free = this.floats.every(([other, right, up]) => Math.hypot(x - right, y - up) > ROOMY * (radius + this.of("radius", other)!));
    if (!free || this.beyond(x, y, ROOMY * radius)) return "There is no room here.";
    this.floats = [...this.floats, [species, x, y, 0, 0]];
    this.begin();
    return "";
  }

  private kept(): Kept {
    return { liquid: this.liquid, choices: this.choices, floats: this.floats };
  }

  /** Go on with what a link says. */
  private bring(kept: Kept): string {
    const { species, factors, room } = this.alone;
    const sizes = Object.values(factors).map((each) => each.length);
    const whole = (value: unknown, below: number): boolean => Number.isInteger(value) && Number(value) >= 0 && Number(value) < below;
    const fits =
      typeof kept === "object" && kept !== null &&
      typeof kept.liquid === "string" && Object.hasOwn(this.liquids, kept.liquid) &&
      Array.isArray(kept.choices) && kept.choices.length === species.length &&
      kept.choices.every((choice) => Array.isArray(choice) && choice.length === 3 && choice.every((one, k) => whole(one, sizes[k]))) &&
      Array.isArray(kept.floats) && kept.floats.length <= room &&
      kept.floats.every((float) => Array.isArray(float) && float.length === 5 && whole(float[0], species.length) && float.every(Number.isFinite) && Math.hypot(float[3], float[4]) <= 10 * this.alone.fastest);
    if (!fits) return "The link does not describe a bowl of this page.";
    const before = this.kept();
    [this.liquid, this.choices] = [kept.liquid, kept.choices];
    const fault = this.fault(kept.floats);
    if (fault) [this.liquid, this.choices] = [before.liquid, before.choices];
    else this.floats = kept.floats;
    this.begin();
    return fault && `The link describes no possible bowl: ${fault}`;
  }

  /** The scene as TOML, as `ecume run` takes it. */
  scene(): string {
    this.keep();
    const lines: string[] = [];
    this.alone.species.forEach(({ name, color }, species) => {
      const mine = this.floats.filter(([one]) => one === species);
      if (!mine.length) return;
      const pairs = (from: number): string => mine.map((float) => `[${float[from]}, ${float[from + 1]}]`).join(", ");
      lines.push("[[particles]]", `name = ${JSON.stringify(name)}`, `count = ${mine.length}`, `color = "${color}"`);
      for (const key of ["radius", "density", "contact_angle"]) lines.push(`${key} = ${this.of(key, species)}`);
      lines.push(`positions = [${pairs(1)}]`, `velocities = [${pairs(3)}]`, "");
    });
    const begin = this.filled.toml.indexOf("[[particles]]");
    const end = this.filled.toml.indexOf("\n[", begin + 2);
    return this.filled.toml.slice(0, begin) + lines.join("\n") + this.filled.toml.slice(end);
  }

  /** As they lie in memory, for tests. */
  places(): number[] {
    return [...this.memory.numbersOf("state.position")];
  }
}

let bowl: Bowl;

globalThis.onmessage = async ({ data }: MessageEvent): Promise<void> => {
  const { number, what, ...more } = data;
  let answer: unknown;
  try {
    if (what === "start") {
      const { instance } = await WebAssembly.instantiate(more.wasm as BufferSource);
      bowl = new Bowl(instance.exports as unknown as Compiled, more.alone, more.liquids);
    } else if (what === "now") answer = bowl.now();
    else if (what === "scene") answer = bowl.scene();
    else if (what === "places") answer = bowl.places();
    else if (what === "go") bowl.go(more.steps);
    else answer = bowl.act(what, more);
    (globalThis as unknown as { postMessage(answer: unknown): void }).postMessage({ number, answer });
  } catch (fault) {
    (globalThis as unknown as { postMessage(answer: unknown): void }).postMessage({ number, fault: String((fault as Error).message ?? fault) });
  }
};

