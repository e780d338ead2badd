// What is seen of floats together: rafts, and the nearest two.

import type { Now } from "./asking";

const TOUCHING = 1.03; // of one raft, in sums of radii

export function apart(seen: Now, one: number, other: number): number {
  return Math.hypot(seen.x[one] - seen.x[other], seen.y[one] - seen.y[other]);
}

/** The sizes of all groups of touching floats, single floats among them. */
export function rafts(seen: Now): number[] {
  const raft = seen.x.map((_, one) => one);
  const root = (one: number): number => (raft[one] === one ? one : (raft[one] = root(raft[one])));
  for (let one = 0; one < seen.x.length; one++) {
    for (let other = 0; other < one; other++) {
      if (apart(seen, one, other) < TOUCHING * (seen.radius[one] + seen.radius[other])) raft[root(one)] = root(other);
    }
  }
  const sizes = new Map<number, number>();
  seen.x.forEach((_, one) => sizes.set(root(one), (sizes.get(root(one)) ?? 0) + 1));
  return [...sizes.values()];
}

/** The nearest two floats, by their numbers; `free`: that do not touch. */
export function nearest(seen: Now, free = false): [number, number] | null {
  let [best, pair]: [number, [number, number] | null] = [Infinity, null];
  for (let one = 1; one < seen.x.length; one++) {
    for (let other = 0; other < one; other++) {
      const both = seen.radius[one] + seen.radius[other];
      const far = apart(seen, one, other);
      if (far - both < best && !(free && far < TOUCHING * both)) [best, pair] = [far - both, [other, one]];
    }
  }
  return pair;
}
