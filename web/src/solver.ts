// The bowl that a page simulates by itself, in a worker: floats as hands and sliders leave them, and ecume's compiled steps.

import type { Now } from "./asking";
import { AS_GIVEN, type Alone, type Chapter, type Filled, type Float, type Kept } from "./chapters";
import { linked, unlinked } from "./links";
import { Floats, type CompiledBowl } from "./floats";
import { answering } from "./worker";

const LONGEST = 0.1; // s of simulated time at once
const BUDGET = 14; // ms of the clock between two pictures
const ROOMY = 1.02; // how far apart centers must be for a new float, in sums of radii
const TRIES = 60; // places around the one that was asked for
const NO_ROOM = "There is no room here.";

type Liquids = Record<string, Filled>;
/** What can be chosen; a change that fails is taken back whole. */
type Choice = Omit<Kept, "floats">;

export class Bowl {
  private memory!: Floats;
  private choice: Choice;
  private floats: Float[];
  private hand: { one: number; x: number; y: number } | null = null;
  private tilt: [number, number] = [0, 0];
  private slope: [number, number] = [0, 0];
  private rate: [number, number] = [0, 0];
  private time = 0;
  private last = 0;
  private speed = 1;
  private pace = 1;
  private step = 0;
  private readonly news: string[] = [];

  constructor(
    private readonly compiled: CompiledBowl,
    private readonly alone: Alone,
    private readonly liquids: Liquids[],
  ) {
    [this.choice, this.floats] = this.beginning(0);
    this.begin();
  }

  private beginning(number: number): [Choice, Float[]] {
    const { species, usual, floats } = this.alone.chapters[number];
    return [{ chapter: number, liquid: AS_GIVEN, dish: AS_GIVEN, choices: species.map(() => [...usual]) }, floats];
  }

  private get chapter(): Chapter {
    return this.alone.chapters[this.choice.chapter];
  }

  private get filled(): Filled {
    return this.liquids[this.choice.chapter][this.choice.liquid];
  }

  private get inDish(): Filled["dishes"][string] {
    return this.filled.dishes[this.choice.dish];
  }

  /** The number of a species' kind in all tables. */
  private kind(species: number): number {
    const sizes = Object.values(this.chapter.factors).map((each) => each.length);
    return this.choice.choices[species].reduce((sum, one, k) => sum * sizes[k] + one, species);
  }

  private of(name: string, species: number): number | null {
    return this.filled.kinds[name][this.kind(species)];
  }

  /** The time step for the species that are there, any of which may be thrown. */
  private get kick(): NonNullable<Filled["steps"][number]> {
    const { usual } = this.chapter;
    const there = [...new Set(this.floats.map(([species]) => species))].map((species) => this.choice.choices[species]);
    const asTheyAre = there.every((choice) => choice.every((one, k) => one === usual[k]));
    const group = asTheyAre ? 0 : 1 + Math.min(...there.map(([size]) => size));
    return (this.filled.steps[group] ?? this.filled.steps.find((one) => one))!;
  }

  /** Memory for the floats there are, at their places. */
  private begin(): void {
    const { filled, floats, compiled } = this;
    const { slots, strength, shares } = this.inDish;
    const kinds = floats.map(([species]) => this.kind(species));
    const { time, decay, gain, mobility } = this.kick;
    const memory = new Floats(compiled, slots, floats.length);
    for (const [name, values] of Object.entries(filled.kinds)) {
      memory.put(`parameters.floats.${name}`, kinds.map((kind) => values[kind]!));
    }
    memory.put("parameters.wall_strength", shares.flatMap((share) => kinds.map((kind) => share * strength[kind])));
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
    const { memory } = this;
    const { swing, current } = this.inDish;
    const seconds = steps * this.step;
    for (const axis of [0, 1]) {
      [this.slope[axis], this.rate[axis]] = memory.swing(this.slope[axis], this.rate[axis], this.tilt[axis], swing, seconds);
    }
    memory.put("parameters.drift.flow", this.chapter.own.map((own, axis) => own + current * this.rate[axis]));
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

  now(): Now {
    this.follow();
    this.keep();
    const { filled, floats, chapter } = this;
    return {
      time: this.time,
      speed: this.speed,
      pace: this.pace,
      news: this.news,
      x: floats.map(([, x]) => x),
      y: floats.map(([, , y]) => y),
      radius: floats.map(([species]) => this.of("radius", species)!),
      species: floats.map(([species]) => species),
      kinds: chapter.species.map(({ name, color }, species) => ({
        name,
        color,
        contact_angle: this.of("contact_angle", species),
        density: this.of("density", species) ?? 0,
        radius: this.of("radius", species) ?? 0,
      })),
      slope: this.slope,
      liquid: filled.liquid,
      capillary_length: filled.capillary_length,
      dish: {},
      surface: "",
      color: filled.color,
      force: floats.length ? [...this.memory.numbersOf("workspace.force")] : [],
      choice: this.choice,
    };
  }

  answer(what: string, asked: Record<string, unknown>): unknown {
    if (what === "now") return this.now();
    if (what === "scene") return this.scene();
    if (what === "places") return this.places();
    return what === "go" ? this.go(Number(asked.steps)) : this.act(what, asked);
  }

  /** Do something; why it was not done, or nothing. */
  private act(what: string, asked: Record<string, unknown>): string {
    const [x, y, one] = [Number(asked.x), Number(asked.y), Number(asked.one)];
    const there = Number.isInteger(one) && one >= 0 && one < this.floats.length;
    const name = String(asked.name);
    this.keep();
    if (what === "speed") this.speed = Number(asked.value);
    else if (what === "tilt") this.tilt = [x, y];
    else if (what === "release") this.hand = null;
    else if (what === "grasp" && there) this.hand = { one, x, y };
    else if (what === "drop") return this.drop(this.chapter.species.findIndex((each) => each.name === name), x, y);
    else if (what === "take" && there) {
      this.floats = this.floats.filter((_, other) => other !== one);
      this.begin();
    } else if (what === "empty") {
      this.floats = [];
      this.begin();
    }
    else if (what === "liquid") return this.changed({ liquid: name }, Object.hasOwn(this.liquids[this.choice.chapter], name));
    else if (what === "dish") return this.changed({ dish: name }, Object.hasOwn(this.chapter.dishes, name));
    else if (what === "kind") return this.another(Number(asked.species), Number(asked.factor), Number(asked.value));
    else if (what === "anew") return this.anew(asked.chapter === undefined ? this.choice.chapter : Number(asked.chapter));
    else if (what === "link") return linked({ ...this.choice, floats: this.floats }, this.alone, Object.keys(this.liquids[this.choice.chapter]));
    else if (what === "bring") return this.bring(String(asked.fragment));
    else return "That cannot be done.";
    return "";
  }

  /** Begin a scene of the page at its beginning. */
  private anew(number: number): string {
    if (!this.alone.chapters[number]) return "There is no such scene.";
    [this.choice, this.floats] = this.beginning(number);
    [this.tilt, this.slope, this.rate, this.time] = [[0, 0], [0, 0], [0, 0], 0];
    this.begin();
    return "";
  }

  private another(species: number, factor: number, value: number): string {
    const choices = this.choice.choices.map((choice) => [...choice]);
    const known = Object.values(this.chapter.factors)[factor]?.[value] !== undefined && choices[species] !== undefined;
    if (known) choices[species][factor] = value;
    return this.changed({ choices }, known);
  }

  /** Try a change of liquid, dish or kinds; nothing changes where a float would sink or find no room. */
  private changed(change: Partial<Choice>, known: boolean): string {
    if (!known) return "There is no such thing to choose.";
    const [choice, floats] = [this.choice, this.floats];
    this.choice = { ...choice, ...change };
    const fault = this.settle();
    if (fault) [this.choice, this.floats] = [choice, floats];
    this.begin();
    return fault;
  }

  /** Move floats that overlap or are beyond the wall to the nearest room. Why that fails, or nothing. */
  private settle(): string {
    const placed: Float[] = [];
    for (const float of this.floats) {
      const [species, x, y] = float;
      const radius = this.of("radius", species);
      if (radius === null) return this.sinks(species);
      if (this.fits(placed, radius, x, y, 0.97, 0.98)) placed.push(float);
      else {
        const room = this.roomNear(placed, radius, x, y, 8 * TRIES);
        if (!room) return "There is no room for all floats: take some out first.";
        placed.push([species, ...room, 0, 0]);
      }
    }
    this.floats = placed;
    return "";
  }

  private sinks(species: number): string {
    return `A ${this.chapter.species[species].name} of this kind sinks in this liquid.`;
  }

  /** Whether a float has room: so many of its radii from the wall, and so many sums of radii from others. */
  private fits(others: Float[], radius: number, x: number, y: number, wall: number, apart: number): boolean {
    return !this.beyond(x, y, wall * radius) &&
      others.every(([other, right, up]) => Math.hypot(x - right, y - up) > apart * (radius + this.of("radius", other)!));
  }

  /** The nearest place on a spiral where a float has room. */
  private roomNear(others: Float[], radius: number, x: number, y: number, tries: number): [number, number] | null {
    for (let number = 0; number < tries; number++) {
      const [away, angle] = [0.5 * radius * Math.sqrt(number), 2.4 * number];
      const place: [number, number] = [x + away * Math.cos(angle), y + away * Math.sin(angle)];
      if (this.fits(others, radius, ...place, ROOMY, ROOMY)) return place;
    }
    return null;
  }

  private beyond(x: number, y: number, radius: number): boolean {
    const { outline } = this.chapter.dishes[this.choice.dish];
    return outline.some(([ax, ay], k) => {
      const [bx, by] = outline[(k + 1) % outline.length];
      const long = Math.hypot(bx - ax, by - ay);
      return long > 0 && ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / long < radius;
    });
  }

  private drop(species: number, x: number, y: number): string {
    if (species < 0) return "There is no such species.";
    if (this.floats.length >= this.alone.room) return `A page has room for ${this.alone.room} floats.`;
    const radius = this.of("radius", species);
    if (radius === null) return this.sinks(species);
    const room = this.beyond(x, y, 0) ? null : this.roomNear(this.floats, radius, x, y, TRIES);
    if (!room) return NO_ROOM;
    this.floats = [...this.floats, [species, ...room, 0, 0]];
    this.begin();
    return "";
  }

  /** Go on with what a link says. */
  private bring(fragment: string): string {
    const before = [this.choice, this.floats] as const;
    try {
      const all = (chapter: Chapter): string[] => Object.keys(this.liquids[this.alone.chapters.indexOf(chapter)]);
      const { floats, ...choice } = unlinked(fragment, this.alone, all);
      [this.choice, this.floats] = [choice, floats];
    } catch (fault) {
      return (fault as Error).message;
    }
    const fault = this.settle();
    if (fault) [this.choice, this.floats] = before;
    this.begin();
    return fault && `The link describes no possible bowl: ${fault}`;
  }

  /** The scene as TOML, as `ecume run` takes it. */
  scene(): string {
    this.keep();
    const tables = this.chapter.species.map(({ name, color }, species) => {
      const mine = this.floats.filter(([one]) => one === species);
      if (!mine.length) return "";
      const pairs = (from: number): string => mine.map((float) => `[${float[from]}, ${float[from + 1]}]`).join(", ");
      const numbers = ["radius", "density", "contact_angle"].map((key) => `${key} = ${this.of(key, species)}`);
      const said = [`name = ${JSON.stringify(name)}`, `count = ${mine.length}`, `color = "${color}"`, ...numbers];
      return ["[[particles]]", ...said, `positions = [${pairs(1)}]`, `velocities = [${pairs(3)}]`, "", ""].join("\n");
    });
    return this.inDish.toml + tables.join("");
  }

  /** As they lie in memory, for tests. */
  places(): number[] {
    return [...this.memory.numbersOf("state.position")];
  }
}

answering((compiled, { alone, liquids }) => new Bowl(compiled as CompiledBowl, alone as Alone, liquids as Liquids[]));
