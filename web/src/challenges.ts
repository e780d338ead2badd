// What a page asks players to do.

import type { Now } from "./asking";
import { apart, nearest, rafts } from "./rafts";
import { element } from "./toy";

interface Challenge {
  name: string;
  met(seen: Now, outline: [number, number][]): boolean;
  told(seen: Now, outline: [number, number][]): string;
}

const STAY = 5; // s
const [FEW, MANY, INSIDE] = [10, 12, 0.9];

/** How far the outermost float reaches, over the nearest point of the wall. */
function outermost(seen: Now, outline: [number, number][]): number {
  const wall = Math.min(...outline.map(([x, y], k) => toLine([x, y], outline[(k + 1) % outline.length])));
  return Math.max(0, ...seen.x.map((x, k) => (Math.hypot(x, seen.y[k]) + seen.radius[k]) / wall));
}

/** The distance of the middle from the line through two corners. */
function toLine([ax, ay]: [number, number], [bx, by]: [number, number]): number {
  const long = Math.hypot(bx - ax, by - ay);
  return long > 0 ? Math.abs(ax * by - ay * bx) / long : Math.hypot(ax, ay);
}

/** Whether the forces on the nearest two floats part them. */
function pushes(seen: Now): boolean {
  const pair = nearest(seen);
  if (!pair || apart(seen, ...pair) === 0) return false;
  const [one, other] = pair;
  const [x, y] = [seen.x[other] - seen.x[one], seen.y[other] - seen.y[one]];
  return (seen.force[2 * other] - seen.force[2 * one]) * x + (seen.force[2 * other + 1] - seen.force[2 * one + 1]) * y > 0;
}

const CHALLENGES: Challenge[] = [
  { name: "none", met: () => false, told: () => "" },
  {
    name: "make two floats repel",
    met: pushes,
    told: () => "The nearest two floats must push each other apart: try a light one and a heavy one.",
  },
  {
    name: `keep ${FEW} floats off the wall`,
    met: (seen, outline) => seen.x.length >= FEW && outermost(seen, outline) < INSIDE,
    told: (seen, outline) => `${seen.x.length} of ${FEW} floats; the outermost reaches ${(100 * outermost(seen, outline)).toFixed(0)} % of the way to the wall, and must stay below ${100 * INSIDE} %.`,
  },
  {
    name: `build a raft of ${MANY}`,
    met: (seen) => Math.max(0, ...rafts(seen)) >= MANY,
    told: (seen) => `The largest raft has ${Math.max(0, ...rafts(seen))} of ${MANY} floats.`,
  },
];

export class Judge {
  private since: number | null = null;
  private done = false;
  private readonly select = element<HTMLSelectElement>("challenge");

  constructor() {
    this.select.append(...CHALLENGES.map(({ name }) => new Option(name)));
    this.select.addEventListener("change", () => [this.since, this.done] = [null, false]);
  }

  /** A challenge is won when its state has lasted; then it stays won. */
  judge(seen: Now, outline: [number, number][]): void {
    const challenge = CHALLENGES[this.select.selectedIndex];
    if (!challenge.met(seen, outline)) this.since = null;
    else if (this.since === null || this.since > seen.time) this.since = seen.time;
    const stayed = this.since === null ? 0 : seen.time - this.since;
    this.done ||= stayed >= STAY;
    const waits = this.since === null ? "" : ` Hold it for ${Math.ceil(STAY - stayed)} s.`;
    const text = this.done ? `Done: you managed to ${challenge.name}.` : challenge.told(seen, outline) + waits;
    if (element("challenge-state").textContent !== text) element("challenge-state").textContent = text;
  }
}
