// What the page says to the server that gave it out, and hears from it.

import type { Kept } from "./chapters";

const token = new URLSearchParams(location.search).get("token") ?? "";

async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  const answer = await fetch(path, { ...init, headers: { "X-Token": token }, cache: "no-store" });
  if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
  return answer;
}

/** What every toy tells of itself. */
export interface Told {
  time: number;
  speed: number;
  pace: number; // 1 where the machine keeps up
  news: string[]; // what happened by itself, so far
}

export interface Kind {
  name: string;
  color: string;
  contact_angle: number | null;
  density: number;
  radius: number;
}

/** How a bowl stands now. Lengths are in meters. */
export interface Now extends Told {
  x: number[];
  y: number[];
  radius: number[];
  species: number[];
  kinds: Kind[];
  slope: [number, number];
  force: number[]; // x and y of each float (N)
  liquid: Record<string, number>;
  capillary_length: number;
  dish: Record<string, number>;
  surface: string; // heights as bytes in base64, 128 being the level
  color?: string | null; // of the liquid, where no heights are shown
  choice?: Omit<Kept, "floats">; // where the page simulates
}

/** How a tank stands now. Lengths are in meters. */
export interface Poured extends Told {
  places: string; // in base64: x and y of each particle, in 65535ths of the view
  colors: string; // in base64: in 255ths of `most`
  coloring: string;
  most: number;
  solids: [number, number][][];
  opened: number; // gates
  wall: number; // how far the left one is pushed
  leaning: number; // rad
  tilt: number; // rad, which it soon has
}

/** How four spheres stand now: lengths in radii, forces in F_N, times in eta R^2 / F_N. */
export interface Pulled extends Told {
  instant: number[]; // time, angle, gaps and tensions of the horizontal, vertical and diagonal films, sliding force
  places: number[]; // x and y of the left, right, top and bottom sphere
  past: number[][]; // time and the three gaps, step by step
  steps: number;
  duration: number | null;
  outcome: string; // empty until it has ended
  chosen: number[];
  pull: [number, number]; // inward forces on the pairs
}

/** Where a page's simulation is: with the server that gave it out, or in the page. */
export interface Asking {
  now<T extends Told>(): Promise<T>;
  scene(): Promise<string>;
  /** Do something; why it was not done, or nothing. */
  act(what: string, more?: Record<string, unknown>): Promise<string>;
}

export const server: Asking = {
  now: async <T extends Told>() => (await (await ask("now")).json()) as T,
  scene: async () => (await ask("scene")).text(),
  async act(what, more = {}) {
    const answer = await ask("do", { method: "POST", body: JSON.stringify({ what, ...more }) });
    return ((await answer.json()) as { said: string }).said;
  },
};
