// A tank in the fragment of a link: gates, tilt and wall, and 13 bytes for each particle.

import { coded, decoded, limited, words } from "./fragments";

const VERSION = 1;
const HEAD = 6; // bytes before the particles
const EACH = 13; // bytes of a particle
const FINEST = 65535;
const FAST = 4; // how fast a particle may be, over the maximum speed
const DENSITIES = [0.5, 1.5] as const; // over that at rest
const MASSES = [0.02, 2] as const; // over that of a full cell

/** What cannot be a link of this page is said with this. */
export const NO_TANK = "The link does not describe a tank of this page.";

/** What a tank can have. */
export interface Limits {
  gates: number;
  steepest: number; // rad
  farthest: number; // m, of the wall
  low: [number, number];
  high: [number, number];
  fastest: number; // m/s
  density: number; // kg/m^3
  cell: number; // kg, the mass of a full cell
  most: number; // particles
  regions: number;
}

export interface Standing {
  opened: number;
  tilt: number;
  wall: number;
  position: [number, number][];
  velocity: [number, number][];
  density: number[];
  mass: number[];
  region: number[];
}

/** The part of a range, from 0 to 1. */
function part(value: number, [low, high]: readonly [number, number]): number {
  return (value - low) / (high - low);
}

function within(share: number, [low, high]: readonly [number, number]): number {
  return low + share * (high - low);
}

/** The ranges of the numbers of a particle. */
function ranges({ low, high, fastest, density, cell }: Limits): (readonly [number, number])[] {
  const [speeds, densities] = [[-FAST * fastest, FAST * fastest] as const, [DENSITIES[0] * density, DENSITIES[1] * density] as const];
  return [[low[0], high[0]], [low[1], high[1]], speeds, speeds, densities, [MASSES[0] * cell, MASSES[1] * cell]];
}

/** The fragment of a tank, without "#". */
export function poured(kept: Standing, limits: Limits): string {
  const bytes = [VERSION, kept.opened];
  const add = (share: number): void => void bytes.push(...words(limited(share * FINEST, 0, FINEST)));
  add(part(kept.tilt, [-limits.steepest, limits.steepest]));
  add(part(kept.wall, [0, limits.farthest]));
  const all = ranges(limits);
  kept.position.forEach(([x, y], one) => {
    [x, y, ...kept.velocity[one], kept.density[one], kept.mass[one]].forEach((value, k) => add(part(value, all[k])));
    bytes.push(kept.region[one]);
  });
  return coded(bytes);
}

/** The tank of a fragment. Throws Error for what is none. */
export function unpoured(fragment: string, limits: Limits): Standing {
  const bytes = decoded(fragment);
  const count = bytes ? (bytes.length - HEAD) / EACH : NaN;
  if (!bytes || bytes[0] !== VERSION || bytes[1] > limits.gates || !Number.isInteger(count) || count < 1 || count > limits.most) throw new Error(NO_TANK);
  const share = (at: number): number => (256 * bytes[at] + bytes[at + 1]) / FINEST;
  const all = ranges(limits);
  const rows = Array.from({ length: count }, (_, one) => all.map((range, k) => within(share(HEAD + EACH * one + 2 * k), range)));
  const region = rows.map((_, one) => bytes[HEAD + EACH * one + EACH - 1]);
  if (region.some((each) => each >= limits.regions)) throw new Error(NO_TANK);
  const tilt = within(share(2), [-limits.steepest, limits.steepest]);
  return {
    opened: bytes[1],
    tilt: Math.abs(tilt) < limits.steepest / FINEST ? 0 : tilt,
    wall: within(share(4), [0, limits.farthest]),
    position: rows.map(([x, y]) => [x, y]),
    velocity: rows.map(([, , u, v]) => [u, v]),
    density: rows.map((row) => row[4]),
    mass: rows.map((row) => row[5]),
    region,
  };
}
