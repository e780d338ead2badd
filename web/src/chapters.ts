// What a page that simulates knows of its scenes; see ecume.show.play.alone and offered.

import type { Slot } from "./memory";

export type Float = [species: number, x: number, y: number, vx: number, vy: number];

export interface Outline {
  outline: [number, number][]; // of the dish (m)
  view: [number, number, number, number]; // left, right, bottom, top
}

export interface Chapter {
  title: string;
  own: [number, number]; // the current of the scene itself (m/s)
  species: { name: string; color: string; radius: number }[];
  factors: Record<string, number[]>;
  usual: number[]; // the choice of factors that leaves a species as it is
  floats: Float[];
  dishes: Record<string, Outline>;
}

export interface Alone {
  title: string;
  speeds: number[];
  steepest: number;
  fastest: number;
  grasp: number;
  room: number;
  chapters: Chapter[];
}

/** All that depends on the liquid. */
export interface Filled {
  liquid: Record<string, number>;
  capillary_length: number;
  color: string | null;
  kinds: Record<string, (number | null)[]>;
  /** for species as they are, then for kinds from each size up */
  steps: ({ time: number; decay: number[]; gain: number[]; mobility: number[] } | null)[];
  dishes: Record<string, InDish>;
}

interface InDish {
  strength: number[]; // of the strongest wall, by kinds (J)
  shares: number[]; // of each wall in it
  swing: number; // rad/s
  current: number; // s^2: velocity of the liquid over the rate of its slope times gravity
  slots: Slot[];
  toml: string;
}

/** What a link brings back. */
export interface Kept {
  chapter: number;
  liquid: string;
  dish: string;
  choices: number[][];
  floats: Float[];
}

export const AS_GIVEN = "as given";
