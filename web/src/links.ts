// A bowl in the fragment of a link, as few characters: places in 65535ths of the view, speeds in 127ths of the fastest.

import type { Alone, Chapter, Kept } from "./chapters";
import { coded, decoded, limited, words } from "./fragments";

const VERSION = 1;
const FINEST = 65535;
const QUICK = 127;

/** What cannot be a link of this page is said with this. */
export const NO_LINK = "The link does not describe a bowl of this page.";

/** The fragment of a bowl, without "#". */
export function linked(kept: Kept, alone: Alone, liquids: string[]): string {
  const chapter = alone.chapters[kept.chapter];
  const [left, right, bottom, top] = chapter.dishes[kept.dish].view;
  const bytes = [VERSION, kept.chapter, liquids.indexOf(kept.liquid), Object.keys(chapter.dishes).indexOf(kept.dish)];
  for (const choice of kept.choices) bytes.push(...choice);
  for (const [species, x, y, vx, vy] of kept.floats) {
    bytes.push(species);
    for (const part of [(x - left) / (right - left), (y - bottom) / (top - bottom)]) {
      bytes.push(...words(limited(part * FINEST, 0, FINEST)));
    }
    for (const speed of [vx, vy]) bytes.push(128 + limited((QUICK * speed) / alone.fastest, -QUICK, QUICK));
  }
  return coded(bytes);
}

/** The bowl of a fragment. Throws Error for what is none. */
export function unlinked(fragment: string, alone: Alone, liquids: (chapter: Chapter) => string[]): Kept {
  const bytes = decoded(fragment);
  if (!bytes) throw new Error(NO_LINK);
  const [version, number] = bytes;
  const chapter = alone.chapters[number];
  if (version !== VERSION || !chapter) throw new Error(NO_LINK);
  const [liquid, dish] = [liquids(chapter)[bytes[2]], Object.keys(chapter.dishes)[bytes[3]]];
  const from = 4 + 3 * chapter.species.length;
  const each = 7;
  const count = (bytes.length - from) / each;
  if (!liquid || !dish || !Number.isInteger(count) || count < 0 || count > alone.room) throw new Error(NO_LINK);
  const choices = chapter.species.map((_, species) => bytes.slice(4 + 3 * species, 7 + 3 * species));
  const [left, right, bottom, top] = chapter.dishes[dish].view;
  const floats = Array.from({ length: count }, (_, k): Kept["floats"][number] => {
    const [species, xHigh, xLow, yHigh, yLow, vx, vy] = bytes.slice(from + each * k, from + each * (k + 1));
    const x = left + ((256 * xHigh + xLow) / FINEST) * (right - left);
    const y = bottom + ((256 * yHigh + yLow) / FINEST) * (top - bottom);
    return [species, x, y, ((vx - 128) / QUICK) * alone.fastest, ((vy - 128) / QUICK) * alone.fastest];
  });
  const sizes = Object.values(chapter.factors).map((factors) => factors.length);
  const known = choices.every((choice) => choice.every((one, k) => one < sizes[k]));
  if (!known || floats.some(([species]) => species >= chapter.species.length)) throw new Error(NO_LINK);
  return { chapter: number, liquid, dish, choices, floats };
}
