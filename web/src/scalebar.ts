// What the colors mean, how long a length is, and where the axes point.

import type { Eye } from "./camera";
import { prefixed, told } from "./told";

export interface Bar {
  rgb: Uint8Array;
  label: string;
  ticks: [number, string][]; // where, from 0 to 1, and what
  shown: [number, number]; // the part of the colors that occurs
}

const CLOSEST = 0.15; // of the bar, between two ticks

/** Fills the bar of colors: a strip, its name, what stands where. */
export function colorBar(parent: HTMLElement, { rgb, label, ticks, shown }: Bar): void {
  parent.replaceChildren();
  const strip = document.createElement("canvas");
  [strip.width, strip.height] = [256, 1];
  const context = strip.getContext("2d")!;
  const image = context.createImageData(256, 1);
  for (let i = 0; i < 256; i++) {
    const color = 3 * Math.round(255 * shown[0] + (shown[1] - shown[0]) * i);
    image.data.set([rgb[color], rgb[color + 1], rgb[color + 2], 255], 4 * i);
  }
  context.putImageData(image, 0, 0);
  strip.className = "strip";
  const name = document.createElement("div");
  name.textContent = label;
  const scale = document.createElement("div");
  scale.className = "ticks";
  let last = -Infinity;
  for (const [place, text] of ticks) {
    const part = (place - shown[0]) / (shown[1] - shown[0]);
    if (part < -0.01 || part > 1.01 || part - last < CLOSEST) continue;
    last = part;
    const tick = document.createElement("span");
    tick.style.left = `${100 * part}%`;
    tick.textContent = text;
    scale.append(tick);
  }
  parent.append(name, strip, scale);
}

/** A bar from one value to another, the unit with the prefix that suits the larger. */
export function scale(rgb: Uint8Array, label: string, unit: string, ends: [number, number], log = false): Bar {
  const [low, high] = ends;
  const { factor, name } = prefixed(Math.max(Math.abs(low), Math.abs(high)), unit);
  const text = (value: number): string => String(Number((value / factor).toPrecision(3)));
  const ticks = log
    ? [0, 0.5, 1].map((part): [number, string] => [part, text(low * (high / low) ** part)])
    : rounded(low, high).map((value): [number, string] => [(value - low) / (high - low), text(value)]);
  return { rgb, label: name ? `${label} (${name})` : label, ticks, shown: [0, 1] };
}

const FEWEST = 3; // ticks, at least
const STEPS = [5, 2.5, 2, 1, 0.5, 0.25, 0.2, 0.1];

/** Round values from one end to the other: multiples of 1, 2, 2.5 or 5 times a power of ten. */
export function rounded(low: number, high: number): number[] {
  const power = 10 ** Math.floor(Math.log10(high - low));
  for (const step of STEPS.map((one) => one * power)) {
    const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
    if (last - first + 1 >= FEWEST) return Array.from({ length: last - first + 1 }, (_, k) => (first + k) * step);
  }
  return [low, high];
}

/** A bar of a round length, about a fifth of the canvas. */
export function lengthBar(bar: HTMLElement, text: HTMLElement, meters: number, pixels: number): void {
  const most = meters / 5;
  const power = 10 ** Math.floor(Math.log10(most));
  const length = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
  bar.style.width = `${(length / meters) * pixels}px`;
  text.textContent = told(length, "m");
}

const LEG = 26; // pixels

/** The axes as an eye sees them: a line and a letter each. */
export function axes(parent: HTMLElement, eye: Eye): void {
  const drawn = [0, 1, 2].map((k) => {
    const [x, y] = [LEG * eye.right[k], -LEG * eye.up[k]];
    const far = Math.hypot(x, y) > 0.3 * LEG ? 1.35 : 2.2;
    const at = (value: number): string => value.toFixed(1);
    return `<line x2="${at(x)}" y2="${at(y)}"/><text x="${at(far * x)}" y="${at(far * y)}">${"xyz"[k]}</text>`;
  });
  parent.innerHTML = `<svg viewBox="-42 -42 84 84" width="84" height="84">${drawn.join("")}</svg>`;
}
