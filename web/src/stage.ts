// What is drawn of an instant, in which order and in which colors.

import { type Camera, type Eye, onCanvas } from "./camera";
import type { GL } from "./gl";
import { Heights } from "./heights";
import { Lines, Segments } from "./lines";
import { regionOf } from "./liquid";
import { Particles } from "./particles";
import type { Coloring, Instant, Link, Run } from "./run";
import { colorsOf } from "./source";
import { Surface } from "./surface";
import { Water } from "./water";

const FAR = 0.25; // a particle that goes farther in a frame, in parts of the picture, went through a periodic side
const WIDEST = 9; // pixels, of the largest force
const PULL = [0.7, 0.09, 0.17, 1];
const PUSH = [0.13, 0.4, 0.67, 1];
const MOST_RIMS = 5000; // particles
const SHADES = 256; // of a scale
const COARSEST = 0.5; // pixels over the page's

export const SPECIES = "species";

export interface Choice {
  coloring: string;
  range: [number, number];
  chosen: number;
  links: boolean;
  particles: boolean; // one by one, of a liquid that is otherwise a region
}

function channels(color: string): [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

const inks = new Map<string, [number, number, number]>();

/** A color of the page's style, from 0 to 1. To ask for it costs as much as to draw hundreds of particles. */
export function styled(name: string): [number, number, number] {
  const known = `${name} ${document.documentElement.dataset.light}`;
  const ink = inks.get(known) ?? asked(name);
  inks.set(known, ink);
  return ink;
}

function asked(name: string): [number, number, number] {
  const value = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const [r, g, b] = channels(value);
  return [r / 255, g / 255, b / 255];
}

/** A color of its own where there is one, from 0 to 1, opaque. */
function paint(color: string | null | undefined, usual: number[]): number[] {
  return color ? [...channels(color).map((value) => value / 255), 1] : usual;
}

/** Three coordinates a particle, whatever the dimension. */
function inSpace(position: Float32Array, dimension: number): Float32Array {
  if (dimension === 3) return position;
  const space = new Float32Array((position.length / 2) * 3);
  for (let i = 0; 2 * i < position.length; i++) {
    space[3 * i] = position[2 * i];
    space[3 * i + 1] = position[2 * i + 1];
  }
  return space;
}

export class Stage {
  private readonly gl: GL;
  private readonly particles: Particles;
  private readonly lines: Lines;
  private readonly heights: Heights | null;
  private readonly span: number;
  private readonly surface: Surface | null; // of a liquid in 2D
  private readonly water: Water | null; // a liquid in 3D
  private readonly above: Particles; // those that are not of the liquid, and the chosen one
  private radii = new Float32Array(0);
  private filled = "";
  private carriedCount = 0;
  private moved = 1; // the part of the way from one frame to the next
  private coarse = 1; // of pixels: less where the machine draws slowly
  shown: Instant | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly run: Run,
    readonly camera: Camera,
  ) {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser does not support WebGL 2");
    this.gl = gl;
    this.particles = new Particles(gl);
    this.lines = new Lines(gl);
    const { sheet, low, high } = run.header;
    this.heights = sheet ? new Heights(gl, sheet) : null;
    if (this.heights && sheet) this.heights.colors.fill(colorsOf(run.header, sheet.map), false);
    const { liquid } = run.header;
    this.surface = liquid && this.flat ? new Surface(gl) : null;
    this.water = liquid && !this.flat ? new Water(gl, Math.min(...liquid.high.map((value, k) => value - liquid.low[k]))) : null;
    this.above = new Particles(gl);
    this.span = Math.hypot(...high.map((value, k) => value - low[k]));
  }

  get aspect(): number {
    return this.canvas.width / this.canvas.height;
  }

  get eye(): Eye {
    return this.camera.eye(this.aspect, this.canvas.height);
  }

  private get flat(): boolean {
    return this.run.header.dimension === 2;
  }

  /** Pixels of the drawing over the page's. */
  private get ratio(): number {
    return this.coarse * Math.min(window.devicePixelRatio || 1, 2);
  }

  /** Draw with fewer pixels, as long as that is to be seen, or with all of them again. */
  hurry(slow: boolean): void {
    this.coarse = slow ? Math.max(COARSEST, 0.75 * this.coarse) : 1;
  }

  coloring(name: string): Coloring | undefined {
    return this.run.header.colorings.find((one) => one.name === name);
  }

  /** Fit the drawing to the room that the page gives it. */
  resize(): boolean {
    const ratio = this.ratio;
    const [width, height] = [this.canvas.clientWidth * ratio, this.canvas.clientHeight * ratio].map(Math.round);
    if (width === this.canvas.width && height === this.canvas.height) return false;
    [this.canvas.width, this.canvas.height] = [Math.max(width, 1), Math.max(height, 1)];
    return true;
  }

  /** Draw a frame, or what lies a part of the way from it to the next. */
  draw(frame: number, part: number, choice: Choice): void {
    const next = part > 0 ? Math.min(frame + 1, this.run.frames - 1) : frame;
    const instant = this.run.instant(next);
    this.moved = next > frame ? part : 1;
    const between = this.whole(choice) ? `${this.moved.toFixed(3)} ${choice.chosen}` : "";
    this.fill(`${frame} ${next} ${choice.coloring} ${choice.particles} ${between}`, this.run.instant(frame), instant, choice);
    this.shown = this.run.instant(frame);
    const { gl } = this;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...styled("--canvas"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    if (this.flat) gl.disable(gl.DEPTH_TEST);
    else gl.enable(gl.DEPTH_TEST);
    this.paint(part, choice);
  }

  private paint(part: number, choice: Choice): void {
    const { eye, gl, canvas } = this;
    this.heights?.draw(eye);
    const whole = this.whole(choice);
    const rims = whole || (this.shown?.count ?? 0) <= MOST_RIMS;
    const look = { part, ink: styled("--ink"), flat: this.flat, rims, chosen: choice.chosen };
    if (whole) {
      this.surface?.draw(eye, this.particles.colors, styled("--rim"));
      this.above.draw(eye, { ...look, chosen: this.carriedCount });
    } else this.particles.draw(eye, look);
    this.lines.fill(this.segments(choice));
    if (this.flat) gl.disable(gl.DEPTH_TEST);
    this.lines.draw(eye, canvas.width, canvas.height);
    // Water is translucent: all that is in it and behind it is drawn before.
    if (whole) this.water?.draw(eye, this.particles.colors, styled("--canvas"), choice.coloring !== SPECIES);
  }

  /** Whether the liquid is drawn as a continuous region. */
  private whole(choice: Choice): boolean {
    return (this.surface !== null || this.water !== null) && !choice.particles;
  }

  private fill(what: string, from: Instant, to: Instant, choice: Choice): void {
    if (what === this.filled) return;
    this.filled = what;
    const d = this.run.header.dimension;
    const place = inSpace(to.position, d);
    const before = from.count === to.count ? inSpace(from.position, d).slice() : place.slice();
    const far = (FAR * this.span) ** 2;
    for (let x = 0; x < place.length; x += 3) {
      const [dx, dy, dz] = [place[x] - before[x], place[x + 1] - before[x + 1], place[x + 2] - before[x + 2]];
      if (dx * dx + dy * dy + dz * dz > far) [before[x], before[x + 1], before[x + 2]] = [place[x], place[x + 1], place[x + 2]];
    }
    const radius = to.arrays["radius"] ?? this.same(to.count);
    const shades = this.shades(to, choice);
    this.particles.colors.fill(this.palette(choice.coloring), true);
    if (!this.whole(choice)) this.particles.fill(place, before, radius, shades);
    else this.fillSurface(place, before, radius, shades, to, choice);
    if (to.sheet) this.heights?.fill(to.sheet);
  }

  /** The region of the liquid between two frames, and what is drawn above it. */
  private fillSurface(
    place: Float32Array,
    before: Float32Array,
    radius: Float32Array,
    shades: Float32Array,
    to: Instant,
    { chosen, coloring }: Choice,
  ): void {
    const [kinds, apart] = [to.arrays[SPECIES], this.run.header.apart ?? Infinity];
    const carried = (one: number): boolean => (kinds?.[one] ?? 0) >= apart;
    const middle = place.map((value, k) => before[k] + this.moved * (value - before[k]));
    (this.surface ?? this.water)!.fill(regionOf(this.run.header.liquid!, middle, shades, (one) => !carried(one)));
    const above = Array.from(shades.keys()).filter((one) => carried(one) && one !== chosen);
    this.carriedCount = above.length;
    if (chosen >= 0 && chosen < shades.length) above.push(chosen);
    const three = (values: Float32Array): Float32Array => Float32Array.from(above.flatMap((one) => [...values.subarray(3 * one, 3 * one + 3)]));
    const some = (values: Float32Array): Float32Array => Float32Array.from(above, (one) => values[one]);
    this.above.fill(three(place), three(before), some(radius), some(shades));
    this.above.colors.fill(this.palette(coloring), true);
  }

  /** The radius of all, where they have none of their own. */
  private same(count: number): Float32Array {
    if (this.radii.length !== count) this.radii = new Float32Array(count).fill(this.run.header.radius);
    return this.radii;
  }

  /** Forget what lies on the graphics card, as after new frames or colors. */
  stale(): void {
    this.filled = "";
  }

  /** Where the color of each particle stands in the palette, from 0 to 1. What has no number keeps its own color. */
  private shades(instant: Instant, { coloring, range }: Choice): Float32Array {
    const { species, apart } = this.run.header;
    const [values, kinds] = [coloring === SPECIES ? undefined : instant.arrays[coloring], instant.arrays[SPECIES]];
    const [own, steps] = [Math.max(species.length, 1), values ? SHADES : 0];
    const [low, high] = range;
    const found = new Float32Array(instant.count);
    for (let one = 0; one < found.length; one++) {
      const kind = kinds?.[one] ?? 0;
      const part = values && kind < (apart ?? Infinity) ? (values[one] - low) / (high - low) : NaN;
      const place = Number.isNaN(part) ? kind : own + Math.round((steps - 1) * Math.min(Math.max(part, 0), 1));
      found[one] = (place + 0.5) / (own + steps);
    }
    return found;
  }

  /** The own colors of all species, and then those of the scale. */
  private palette(coloring: string): Uint8Array {
    const { header } = this.run;
    const own = header.species.length ? header.species.flatMap((one) => channels(one.color)) : [90, 120, 160];
    const found = this.coloring(coloring);
    return new Uint8Array(found ? [...own, ...colorsOf(header, found.map)] : own);
  }

  private segments(choice: Choice): Segments {
    const segments = new Segments();
    const ink = [...styled("--rim"), 1];
    const { ratio } = this;
    for (const line of this.run.header.outlines) {
      const color = line.dashed ? [...styled("--muted"), 1] : paint(line.color, ink);
      segments.path(line.points, line.closed, color, (line.dashed ? 1 : 2) * ratio);
    }
    const instant = this.shown;
    if (!instant) return segments;
    const d = this.run.header.dimension;
    for (const [k, mover] of instant.movers.entries()) {
      const points = Array.from({ length: mover.length / d }, (_, i) => mover.subarray(d * i, d * i + d));
      segments.path(points, d === 2, paint(this.run.header.painted[k], ink), 2 * ratio);
    }
    if (instant.links && choice.links) {
      this.forces(segments, instant.links, ratio);
      if (d === 2) this.films(segments, instant.links, ratio);
    }
    return segments;
  }

  /** Contact forces as lines from center to center, as wide as the force is large; films across them, by their gap. */
  private forces(segments: Segments, links: Link, ratio: number): void {
    const d = this.run.header.dimension;
    const tension = this.run.range("links/tension");
    const largest = Math.max(Math.abs(tension[0]), Math.abs(tension[1])) || 1;
    for (let c = 0; c < links.gap.length; c++) {
      const width = (WIDEST * ratio * Math.abs(links.tension[c])) / largest;
      if (width < 0.15) continue;
      const first = links.x.subarray(d * c, d * c + d);
      const second = first.map((value, k) => value + links.along[d * c + k]);
      segments.add(first, second, links.tension[c] > 0 ? PULL : PUSH, width);
    }
  }

  /** Films across the lines of centers, colored by their gap. */
  private films(segments: Segments, links: Link, ratio: number): void {
    const [low, high] = this.gaps;
    const films = colorsOf(this.run.header, "viridis");
    for (let c = 0; c < links.gap.length; c++) {
      const gap = links.gap[c];
      if (gap > high * 1.0001) continue;
      const [x, y] = [links.x[2 * c], links.x[2 * c + 1]];
      const [dx, dy] = [links.along[2 * c], links.along[2 * c + 1]];
      const part = high > low ? Math.log(gap / low) / Math.log(high / low) : 0.5;
      const place = 3 * Math.round(255 * Math.min(Math.max(part, 0), 1));
      const color = [0, 1, 2].map((k) => films[place + k] / 255);
      const [mx, my] = [x + 0.5 * dx, y + 0.5 * dy];
      const [sx, sy] = [-0.13 * dy, 0.13 * dx];
      segments.add([mx - sx, my - sy], [mx + sx, my + sy], [...color, 1], 4 * ratio);
    }
  }

  /** The gaps that films have in this run, from the narrowest to the widest that is drawn (m). */
  get gaps(): [number, number] {
    const [low, high] = this.run.range("links/gap").map(Math.exp);
    return [low, Math.min(high, this.run.header.widest)];
  }

  /** The particle under a point of the canvas, given from -1 to 1 in both directions; -1 where there is none. */
  at(x: number, y: number): number {
    const [instant, eye, d] = [this.shown, this.eye, this.run.header.dimension];
    if (!instant) return -1;
    let [best, nearest] = [-1, Infinity];
    for (let i = 0; i < instant.count; i++) {
      const place = instant.position.subarray(d * i, d * i + d);
      const seen = onCanvas(eye, place);
      const apart = Math.hypot((seen[0] - x) * this.aspect, seen[1] - y);
      const own = instant.arrays["radius"]?.[i] ?? this.run.header.radius;
      const radius = (2 * own) / (eye.pixel * this.canvas.height);
      if (!own || apart > Math.max(radius, 0.012)) continue; // of radius 0 are those that have left
      const rank = d === 3 ? seen[2] : apart;
      if (rank < nearest) [best, nearest] = [i, rank];
    }
    return best;
  }
}
