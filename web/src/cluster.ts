// The four spheres that a page simulates by itself, in a worker: ecume's compiled steps, one after the other.

import type { Pulled } from "./asking";
import { Memory, type Compiled, type Slot } from "./memory";
import { answering } from "./worker";

const LONGEST = 0.1; // s of the clock at once
const BUDGET = 14; // ms of the clock between two pictures
const RESULT_OF_A_STEP = ["going on", "ended", "stuck"] as const;
const INSTANT = 9; // numbers: time, angle, three gaps, three tensions, sliding force
const NO_LINK = "The link does not describe a cluster of this page.";

/** A cluster's numbers where they are not those of the first, how fast it is played, its forces and its scene. */
interface Case {
  slots: Record<string, (number | string)[] | number | string>;
  rate: number;
  pull: [number, number];
  scene: string;
}

export interface Clusters {
  choices: number[][]; // gaps, forces, ratios
  begins: number[];
  slots: Slot[];
  cases: Case[];
  outcomes: string[];
}

interface CompiledCluster extends Compiled {
  begin(block: number): number;
  follow(block: number): number;
  outcome(block: number): number;
}

/** One process, step after step. */
class Process extends Memory {
  readonly instants: number[][] = [];
  readonly centers: number[][] = [];
  state: (typeof RESULT_OF_A_STEP)[number] = "going on";

  constructor(
    private readonly compiled: CompiledCluster,
    slots: Slot[],
  ) {
    super(compiled, slots);
    if (!this.call(compiled.begin)) throw new Error("The forces at rest could not be computed.");
    this.keep();
  }

  /** Take a step. */
  step(): void {
    this.state = this.call(this.compiled.follow) ? RESULT_OF_A_STEP[this.answered] : "stuck";
    if (this.state !== "stuck") this.keep();
  }

  private keep(): void {
    this.instants.push([...this.numbersOf("cluster.instants").slice(INSTANT, 2 * INSTANT)]);
    this.centers.push([...this.numbersOf("cluster.step.bodies.before")]);
  }

  /** The time until the vertical pair carries its part. */
  get duration(): number {
    return this.numbersOf("cluster.seen.found")[0];
  }

  get end(): number {
    return this.instants[this.instants.length - 1][0];
  }

  /** How it ended, as a place in the list of outcomes. */
  outcome(): number {
    const least = Math.min(...this.instants.map((instant) => instant[3]));
    const at = this.of(this.compiled.outcome, [this.duration, this.instants[this.instants.length - 1][4], least]);
    return Number(this.fresh().getBigInt64(at, true));
  }
}

class Spheres {
  private process!: Process;
  private time = 0;
  private last = 0;
  private speed = 1;
  private pace = 1;
  private chosen: number[];
  private news: string[] = [];

  constructor(
    private readonly compiled: CompiledCluster,
    private readonly told: Clusters,
  ) {
    this.chosen = [...told.begins];
    this.begin();
  }

  private get case(): Case {
    const [gap, force, ratio] = this.chosen;
    const [, forces, ratios] = this.told.choices;
    return this.told.cases[(gap * forces.length + force) * ratios.length + ratio];
  }

  private begin(): void {
    const own = this.case.slots;
    const slots = this.told.slots.map(([name, kind, sizes, value]): Slot => [name, kind, sizes, name in own ? own[name] : value]);
    this.process = new Process(this.compiled, slots);
    [this.time, this.last] = [0, 0];
  }

  /** As far as the clock has gone, or as far as there is time for. */
  private follow(): void {
    const [now, { process }] = [performance.now(), this];
    const due = this.speed * this.case.rate * Math.min(LONGEST, (now - (this.last || now)) / 1000);
    this.last = now;
    const aim = this.time + due;
    while (process.state === "going on" && process.end < aim && performance.now() - now < BUDGET) this.advance();
    const reached = Math.min(aim, process.end);
    if (due > 0 && process.state === "going on") this.pace += 0.1 * ((reached - this.time) / due - this.pace);
    this.time = reached;
  }

  private advance(): void {
    this.process.step();
    if (this.process.state === "stuck") this.news.push("No step is short enough: the process ends here.");
  }

  private now(): Pulled {
    this.follow();
    const { process, time } = this;
    const { instants, centers } = process;
    let next = instants.findIndex(([end]) => end >= time);
    if (next < 0) next = instants.length - 1;
    const from = Math.max(0, next - 1);
    const [begin, end] = [instants[from][0], instants[next][0]];
    const part = end > begin ? (time - begin) / (end - begin) : 1;
    const between = (one: number[], other: number[]): number[] => one.map((value, k) => value + part * (other[k] - value));
    const over = process.state !== "going on" && next === instants.length - 1 && time >= end;
    return {
      time, speed: this.speed, pace: this.pace, news: this.news,
      instant: between(instants[from], instants[next]),
      places: between(centers[from], centers[next]),
      past: instants.slice(0, next + 1).map(([at, , ...gaps]) => [at, ...gaps.slice(0, 3)]),
      steps: next,
      duration: over && Number.isFinite(process.duration) ? process.duration : null,
      outcome: over ? this.told.outcomes[process.outcome()] : "",
      chosen: this.chosen,
      pull: this.case.pull,
    };
  }

  answer(what: string, asked: Record<string, unknown>): unknown {
    if (what === "now") return this.now();
    if (what === "scene") return this.scene();
    return what === "whole" ? this.whole() : this.act(what, asked);
  }

  /** Do something; why it was not done, or nothing. */
  private act(what: string, asked: Record<string, unknown>): string {
    if (what === "speed") this.speed = Number(asked.value);
    else if (what === "anew") this.begin();
    else if (what === "choose") return this.choose(this.chosen.map((one, k) => (k === asked.which ? Number(asked.value) : one)));
    else if (what === "link") return `t1-${this.chosen.join("-")}`;
    else if (what === "bring") {
      const found = /^t1-(\d{1,2})-(\d{1,2})-(\d{1,2})$/.exec(String(asked.fragment));
      return found ? this.choose(found.slice(1).map(Number)) : NO_LINK;
    } else return "That cannot be done.";
    return "";
  }

  private choose(chosen: number[]): string {
    if (chosen.some((one, k) => this.told.choices[k][one] === undefined)) return NO_LINK;
    this.chosen = chosen;
    this.begin();
    return "";
  }

  private scene(): string {
    return this.case.scene;
  }

  /** The whole process at once, for tests. */
  private whole(): { duration: number; steps: number; outcome: string } {
    while (this.process.state === "going on") this.advance();
    const { duration, instants } = this.process;
    return { duration, steps: instants.length - 1, outcome: this.told.outcomes[this.process.outcome()] };
  }
}

answering((compiled, { cases }) => new Spheres(compiled as CompiledCluster, cases as Clusters));
