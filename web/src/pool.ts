// The tank that a page simulates by itself, in a worker: liquid as hands leave it, and ecume's compiled steps.

import type { Poured } from "./asking";
import { Memory, type Compiled, type Numbers, type Slot } from "./memory";
import { poured, unpoured, type Limits } from "./pours";
import { answering } from "./worker";

const BUDGET = 28; // ms of the clock between two pictures
const LONGEST = 0.05; // s of simulated time at once: a machine that is too slow plays in slow motion
const BATCH = 4; // steps in one call: what a call has made it gives back at its end
const GRASP = 0.15; // s in which the tank reaches its tilt, the wall the hand, and a wall its highest speed
const STILL = 1e-5; // rad from its tilt, within which it has reached it; of the width, within which the wall is back
const SOON = 0.2; // s after which liquid that was calmed and breaks again is not worth keeping
const [DONE, EXCHANGE] = [0, 3];
const FINEST = 65535;

/** The liquid, particle by particle. */
interface Liquid {
  position: [number, number][];
  velocity: [number, number][];
  density: number[];
  mass: number[];
  region: number[];
}

interface Basins {
  slots: Slot[][]; // for each number of open gates
  solids: [number, number][][][];
  scenes: [string, string][]; // TOML without liquid, gauges and tilt, before and behind the place of the left wall
  gauges: [number, string][]; // the left end of each, and its table: none may be in the wall
  movable: boolean; // whether that wall is
  hurry: number; // its largest speed, over the maximum speed
  pushed: number; // its largest displacement, over the width
  stroke: number; // of a wave, over the width
  liquid: Liquid;
  colors: (string | null)[]; // of the regions
  low: [number, number];
  high: [number, number]; // of the view
  top: [number, number]; // of the tank
  ends: { speed: number; pressure: number }; // of the scales of colors
  density: number; // kg/m^3, at rest
  spacing: number;
  clearance: [number, number]; // of new liquid, and of what a gate pushes aside (m)
  room: number; // between particles, in spacings
  jet: number;
  ladle: number; // radii in spacings
  most: number; // particles
  steepest: number; // rad
  pressure: number; // the row of pressures
}

interface CompiledTank extends Compiled {
  put(block: number): number;
  advance(block: number): number;
  gap(block: number): number;
  lean(block: number): number;
  push(block: number): number;
  wall(block: number): number;
  period(block: number): number;
}

/** The memory of a tank with so many particles. */
class Basin extends Memory {
  constructor(
    private readonly compiled: CompiledTank,
    slots: Slot[],
    liquid: Liquid,
    wall: number,
  ) {
    super(compiled, slots, liquid.mass.length);
    const lines = this.numbersOf("basin.walls.path.lines");
    lines[lines.length / 2] = wall;
    for (const name of ["position", "velocity"] as const) {
      this.put(`drops.${name}`, [0, 1].flatMap((axis) => liquid[name].map((each) => each[axis])));
    }
    for (const name of ["density", "mass", "region"] as const) this.put(`drops.${name}`, liquid[name]);
    this.put("drops.identity", liquid.mass.map((_, one) => one));
    if (!this.call(compiled.put)) throw new Error("The tank could not be filled.");
  }

  /** Take so many steps: the status of `ecume.models.model`. */
  advance(steps: number): number {
    this.put("steps", [steps]);
    return this.call(this.compiled.advance) ? this.answered : -1;
  }

  get steps(): number {
    return this.whole("drops.step");
  }

  /** The distance of a place from the nearest wall (m), negative in solids. */
  gap(x: number, y: number): number {
    this.put("room.asked", [x, y]);
    this.call(this.compiled.gap);
    return this.numbersOf("room.answer")[0];
  }

  /** Turn gravity against the tank. */
  lean(angle: number): void {
    this.put("room.asked", [angle]);
    this.call(this.compiled.lean);
  }

  /** Let the left wall reach a speed (m/s) in a time (s). */
  push(speed: number, seconds: number): void {
    this.put("room.asked", [speed, seconds]);
    this.call(this.compiled.push);
  }

  /** How fast it will be then. */
  get pace(): number {
    return this.numbersOf("basin.walls.path.speed")[0];
  }

  /** How far it is pushed (m). */
  get wall(): number {
    this.call(this.compiled.wall);
    return this.numbersOf("room.answer")[0];
  }

  /** The period of sloshing in a tank of this width (s). */
  period(width: number): number {
    this.put("room.asked", [width]);
    this.call(this.compiled.period);
    return this.numbersOf("room.answer")[0];
  }

  /** A row of the table of fields: see `table_of` in `ecume.show.play.tank_steps`. */
  row(number: number): Numbers {
    const images = this.wholes("room.first").pop()!;
    return this.numbersOf("room.fields").subarray(number * (this.countOf("room.counts") + images));
  }

  /** The acceleration beside gravity (m/s^2). */
  get pull(): number[] {
    return [...this.numbersOf("basin.gravity")].map((each, axis) => each - this.numbersOf("basin.upright")[axis]);
  }

  /** The liquid at present, in the order of its numbers. */
  liquid(): Liquid {
    return inOrder(this.kept());
  }

  /** The same as it lies there. */
  kept(): Kept {
    const [position, velocity, density, mass] = ["position", "velocity", "density", "mass"].map((name) => this.numbersOf(`drops.${name}`).slice());
    return { position, velocity, density, mass, numbers: this.wholes("drops.identity"), region: this.wholes("drops.region") };
  }
}

/** Liquid as it lies in memory, first x of all particles, then y. */
interface Kept {
  position: Numbers;
  velocity: Numbers;
  density: Numbers;
  mass: Numbers;
  numbers: number[];
  region: number[];
}

function inOrder({ position, velocity, density, mass, numbers, region }: Kept): Liquid {
  const order = [...numbers.keys()].sort((one, other) => numbers[one] - numbers[other]);
  const pairs = (of: Numbers): [number, number][] => order.map((one) => [of[one], of[mass.length + one]]);
  return {
    position: pairs(position),
    velocity: pairs(velocity),
    density: order.map((one) => density[one]),
    mass: order.map((one) => mass[one]),
    region: order.map((one) => region[one]),
  };
}

class Pool {
  private basin!: Basin;
  private opened = 0;
  private time = 0;
  private last = 0;
  private speed = 1;
  private pace = 1;
  private tilt = 0;
  private leaning = 0;
  private aim = 0; // of the wall (m)
  private waved = -Infinity; // s, when a wave began
  private calmed = -Infinity;
  private coloring: "speed" | "pressure" = "speed";
  private readonly news: string[] = [];

  constructor(
    private readonly compiled: CompiledTank,
    private readonly told: Basins,
  ) {
    this.begin(told.liquid, 0);
  }

  /** Go on with this liquid, and the wall where it is. */
  private begin(liquid: Liquid, wall = this.basin.wall): void {
    this.basin = new Basin(this.compiled, this.told.slots[this.opened], liquid, wall);
    this.basin.lean(this.leaning);
  }

  private get timeStep(): number {
    return this.basin.numbersOf("basin.time_step")[0];
  }

  /** As far as the clock has gone, or as far as there is time for. */
  private follow(): void {
    const now = performance.now();
    const due = this.speed * Math.min(LONGEST, (now - (this.last || now)) / 1000);
    this.last = now;
    if (due <= 0) return;
    const steps = Math.max(1, Math.round(due / this.timeStep));
    const way = this.tilt - this.leaning;
    this.leaning = Math.abs(way) < STILL ? this.tilt : this.leaning + Math.min(1, (steps * this.timeStep) / GRASP) * way;
    this.basin.lean(this.leaning);
    if (this.told.movable) this.pushOn(steps * this.timeStep);
    const kept = this.basin.kept();
    let taken = 0;
    while (taken < steps && performance.now() - now < BUDGET) {
      const each = Math.min(BATCH, steps - taken);
      if (!this.go(each, kept)) break;
      taken += each;
    }
    this.pace += 0.1 * ((taken * this.timeStep) / due - this.pace);
  }

  private get width(): number {
    return this.told.top[0] - this.told.low[0];
  }

  /** Move the wall toward the hand, or where the wave has it, during a time (s): as `Tank._take_hands` does. */
  private pushOn(seconds: number): void {
    const { basin, told } = this;
    const fastest = told.hurry * told.ends.speed;
    const phase = (this.time + GRASP - this.waved) / basin.period(this.width);
    const target = phase > 1 ? this.aim : 0.5 * told.stroke * this.width * (1 - Math.cos(2 * Math.PI * phase));
    const wanted = limited((target - basin.wall) / GRASP, -fastest, fastest);
    const more = (fastest * seconds) / GRASP;
    basin.push(limited(wanted, basin.pace - more, basin.pace + more), seconds);
  }

  /** Take some steps; what breaks is brought to rest where it last was whole. */
  private go(steps: number, kept: Kept): boolean {
    const before = this.basin.steps;
    const status = this.basin.advance(steps);
    if (status === DONE || status === EXCHANGE) this.time += (this.basin.steps - before) * this.timeStep;
    if (status === DONE) return true;
    if (status === EXCHANGE) this.begin(this.without(this.basin.liquid(), this.lost(this.basin.liquid())));
    else this.calm(inOrder(kept));
    return false;
  }

  /** Whether each particle is beyond an open side. */
  private lost({ position }: Liquid): boolean[] {
    const bounds = this.basin.numbersOf("basin.bounds");
    return position.map((place) => place.some((x, axis) => x < bounds[axis] || x > bounds[2 + axis]));
  }

  private calm(kept: Liquid): void {
    if (this.time - this.calmed < SOON) {
      this.anew();
      this.news.push("The liquid could not be brought to rest: the tank was restarted.");
      return;
    }
    this.calmed = this.time;
    this.begin({ ...kept, velocity: kept.velocity.map(() => [0, 0]) });
    this.news.push("The liquid went too fast for its time step: it was brought to rest where it stood.");
  }

  private anew(): void {
    [this.opened, this.tilt, this.leaning, this.aim, this.waved, this.calmed] = [0, 0, 0, 0, -Infinity, -Infinity];
    this.begin(this.told.liquid, 0);
  }

  private without(liquid: Liquid, gone: boolean[]): Liquid {
    const some = <T>(of: T[]): T[] => of.filter((_, one) => !gone[one]);
    const { position, velocity, density, mass, region } = liquid;
    return { position: some(position), velocity: some(velocity), density: some(density), mass: some(mass), region: some(region) };
  }

  private now(): Poured {
    this.follow();
    const { basin, told, coloring } = this;
    const [position, velocity] = [basin.numbersOf("drops.position"), basin.numbersOf("drops.velocity")];
    const count = position.length / 2;
    const most = told.ends[coloring];
    const [places, colors] = [new Uint16Array(2 * count), new Uint8ClampedArray(count)];
    const pressure = basin.row(told.pressure);
    for (let one = 0; one < count; one++) {
      for (const axis of [0, 1]) {
        const part = (position[axis * count + one] - told.low[axis]) / (told.high[axis] - told.low[axis]);
        places[2 * one + axis] = Math.min(Math.max(part, 0), 1) * FINEST;
      }
      const value = coloring === "speed" ? Math.hypot(velocity[one], velocity[count + one]) : pressure[one];
      colors[one] = (255 * value) / most;
    }
    return {
      time: this.time, speed: this.speed, pace: this.pace, news: this.news,
      places: coded(new Uint8Array(places.buffer)), colors: coded(new Uint8Array(colors.buffer)),
      coloring, most, solids: told.solids[this.opened], opened: this.opened, wall: basin.wall, leaning: this.leaning, tilt: this.tilt,
    };
  }

  answer(what: string, asked: Record<string, unknown>): unknown {
    if (what === "now") return this.now();
    if (what === "scene") return this.scene();
    return what === "steps" ? this.steps(Number(asked.steps)) : this.act(what, asked);
  }

  /** Do something; why it was not done, or nothing. */
  private act(what: string, asked: Record<string, unknown>): string {
    const [x, y] = [Number(asked.x), Number(asked.y)];
    if (what === "speed") this.speed = Number(asked.value);
    else if (what === "pour") return this.pour(x, y);
    else if (what === "scoop") return this.scoop(x, y);
    else if (what === "open") return this.open();
    else if (what === "close") return this.close();
    else if (what === "lean") this.tilt = limited(Number(asked.angle), -this.told.steepest, this.told.steepest);
    else if ((what === "drag" || what === "wave") && !this.told.movable) return "the left side of this tank is not a movable wall";
    else if (what === "drag") [this.aim, this.waved] = [limited(x - this.told.low[0], 0, this.told.pushed * this.width), -Infinity];
    else if (what === "wave") [this.aim, this.waved] = [0, this.time];
    else if (what === "anew") this.anew();
    else if (what === "link") return this.link();
    else if (what === "bring") return this.bring(String(asked.fragment));
    else if (what === "color" && (asked.name === "speed" || asked.name === "pressure")) this.coloring = asked.name;
    else return "That cannot be done.";
    return "";
  }

  /** What a link can describe. */
  private get limits(): Limits {
    const { told } = this;
    const { steepest, low, high, density, spacing, most } = told;
    const [gates, regions, farthest] = [told.slots.length - 1, told.colors.length + 1, told.pushed * this.width];
    return { gates, regions, farthest, fastest: told.ends.speed, cell: density * spacing * spacing, steepest, low, high, density, most };
  }

  private link(): string {
    return poured({ ...this.basin.liquid(), opened: this.opened, tilt: this.tilt, wall: this.basin.wall }, this.limits);
  }

  /** Go on with what a link says. */
  private bring(fragment: string): string {
    try {
      const { opened, tilt, wall, ...liquid } = unpoured(fragment, this.limits);
      this.anew();
      [this.opened, this.tilt, this.leaning, this.aim] = [opened, tilt, tilt, this.told.movable ? wall : 0];
      this.begin(liquid, this.aim);
    } catch (fault) {
      return (fault as Error).message;
    }
    return "";
  }

  private pour(x: number, y: number): string {
    const { told } = this;
    const { spacing, jet, density } = told;
    const liquid = this.basin.liquid();
    const steps = Array.from({ length: 2 * Math.floor(jet) + 1 }, (_, k) => (k - Math.floor(jet)) * spacing);
    const near = steps.flatMap((right) => steps.map((up): [number, number] => [x + right, y + up])).filter(([px, py]) => Math.hypot(px - x, py - y) <= jet * spacing);
    const places = near.filter((place) => this.isFree(place, liquid.position));
    if (!places.length) return "no room for liquid here";
    if (liquid.mass.length + places.length > told.most) return `the tank has ${liquid.mass.length} particles; expected at most ${told.most}; scoop out some liquid`;
    const each = <T>(value: T): T[] => places.map(() => value);
    this.begin({
      position: [...liquid.position, ...places],
      velocity: [...liquid.velocity, ...places.map((): [number, number] => [0, 0])],
      density: [...liquid.density, ...each(density)],
      mass: [...liquid.mass, ...each(density * spacing * spacing)],
      region: [...liquid.region, ...each(told.colors.length)],
    });
    return "";
  }

  /** Whether a new particle has room here: inside of the tank, off solids and off other liquid. */
  private isFree(place: [number, number], taken: [number, number][]): boolean {
    const { told } = this;
    const [apart, edge] = [told.room * told.spacing, 0.5 * told.spacing];
    const inside = place.every((x, axis) => x > told.low[axis] + edge + (axis ? 0 : this.basin.wall) && x < told.top[axis] - edge);
    return inside && this.basin.gap(...place) > told.clearance[0] && taken.every(([x, y]) => Math.hypot(x - place[0], y - place[1]) > apart);
  }

  private scoop(x: number, y: number): string {
    const liquid = this.basin.liquid();
    const gone = liquid.position.map((place) => Math.hypot(place[0] - x, place[1] - y) <= this.told.ladle * this.told.spacing);
    if (!gone.includes(true)) return "no liquid here";
    if (!gone.includes(false)) return "the last of it stays";
    this.begin(this.without(liquid, gone));
    return "";
  }

  private open(): string {
    if (this.opened + 1 >= this.told.slots.length) return "no gate to open";
    const liquid = this.basin.liquid();
    this.opened++;
    this.begin(liquid);
    return "";
  }

  /** Restore the gate that was removed last; liquid there goes to the nearest free places, the highest first. */
  private close(): string {
    if (!this.opened) return "no gate to close";
    const { told } = this;
    const liquid = this.basin.liquid();
    this.opened--;
    this.begin(liquid);
    const within = liquid.position.map(([x, y]) => this.basin.gap(x, y) <= told.clearance[1]);
    const moved = [...within.keys()].filter((one) => within[one]).sort((one, other) => liquid.position[other][1] - liquid.position[one][1]);
    const rest = liquid.position.filter((_, one) => !within[one]);
    const along = (axis: number): number[] => {
      const count = Math.ceil((told.top[axis] - told.low[axis]) / told.spacing - 0.5);
      return Array.from({ length: count }, (_, k) => told.low[axis] + (k + 0.5) * told.spacing);
    };
    const places = moved.length ? along(0).flatMap((x) => along(1).map((y): [number, number] => [x, y])).filter((place) => this.isFree(place, rest)) : [];
    if (places.length < moved.length) {
      this.opened++;
      this.begin(liquid);
      return "the liquid at the gate has no room; scoop out some liquid";
    }
    for (const one of moved) {
      const [x, y] = liquid.position[one];
      const away = places.map(([px, py]) => (px - x) ** 2 + (py - y) ** 2);
      [liquid.position[one]] = places.splice(away.indexOf(Math.min(...away)), 1);
      [liquid.velocity[one], liquid.density[one]] = [[0, 0], told.density];
    }
    this.begin(liquid);
    return "";
  }

  /** The scene as TOML, as `ecume run` takes it. */
  private scene(): string {
    const { told, basin } = this;
    const liquid = basin.liquid();
    const regions = [...new Set(liquid.region)].sort((one, other) => one - other);
    const pairs = (of: [number, number][]): string => `[${of.map(([x, y]) => `[${x}, ${y}]`).join(", ")}]`;
    const tables = regions.map((region) => {
      const mine = this.without(liquid, liquid.region.map((one) => one !== region));
      const color = told.colors[region] ? [`color = ${JSON.stringify(told.colors[region])}`] : [];
      return ["[[fluid]]", ...color, "", "[fluid.particles]", `positions = ${pairs(mine.position)}`, `velocities = ${pairs(mine.velocity)}`,
        `densities = [${mine.density.join(", ")}]`, `masses = [${mine.mass.join(", ")}]`, "", ""].join("\n"); // prettier-ignore
    });
    const [right, up] = basin.pull;
    const leans = this.leaning === 0 ? "" : `[base_excitation]\ntimes = [0.0]\naccelerations = [[${right}, ${up}]]\n`;
    const [before, after] = told.scenes[this.opened];
    const left = told.low[0] + (Math.abs(basin.wall) > STILL * this.width ? basin.wall : 0);
    const gauges = told.gauges.filter(([x]) => x >= left).map(([, table]) => `${table.trimEnd()}\n\n`);
    return before + left + after + gauges.join("") + tables.join("") + leans;
  }

  /** So many steps at once, and what there is then, for tests: places, and energies as `ecume.models.sph` has them. */
  private steps(steps: number): { liquid: Liquid; steps: number; seconds: number; status: number } {
    const began = performance.now();
    let status = DONE;
    for (let taken = 0; taken < steps && status === DONE; taken += BATCH) status = this.basin.advance(Math.min(BATCH, steps - taken));
    return { liquid: this.basin.liquid(), steps: this.basin.steps, seconds: (performance.now() - began) / 1000, status };
  }
}

function limited(value: number, least: number, most: number): number {
  return Math.min(Math.max(value, least), most);
}

function coded(bytes: Uint8Array): string {
  let text = "";
  for (let at = 0; at < bytes.length; at += 4096) text += String.fromCharCode(...bytes.subarray(at, at + 4096));
  return btoa(text);
}

answering((compiled, { cases }) => new Pool(compiled as CompiledTank, cases as Basins));
