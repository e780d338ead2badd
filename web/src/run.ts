// A run as the page holds it: chunks of frames, each with its own quantization, one after the other.

import type { Tank } from "./liquid";

export interface Coloring {
  name: string;
  unit: string;
  map: string;
}

export interface Place {
  offset: number;
  length: number;
  kind: "u1" | "u2" | "u4" | "f4";
  rows?: number; // so many frames, each as how far all went since the one before
}

export interface Polyline {
  points: number[][];
  closed: boolean;
  dashed: boolean;
  color: string | null; // null: as walls are
}

export interface Sheet {
  columns: number;
  rows: number;
  view: [number, number, number, number]; // left, right, bottom, top (m)
  walls: [number, number, number][]; // the surface is where n.x >= offset (m) for each (n_x, n_y, offset)
  round: number; // and inside this radius (m); 0 for none
  map: string;
  label: string;
  shown: [number, number]; // the part of the scale that occurs, from 0 to 1
  ticks: [number, string][]; // where on the scale, and what stands there
}

/** What one chunk says of itself. Arrays of particles stand frame after frame, (particle, axis) within. */
export interface ChunkHeader {
  times: number[];
  counts: number[];
  places: Record<string, Place>;
  ranges: Record<string, [number, number]>;
  scales: Record<string, [number, number]>; // between which nearly all values lie
  steady: string[]; // arrays that never change: they stand once
  movers: number[]; // how many points each moving outline has
  links: number[]; // how many contacts each frame has
}

/** What the whole run says of itself. */
export interface RunHeader {
  title: string;
  model: string;
  dimension: 2 | 3;
  up: "y" | "z"; // the axis that points up (3D)
  low: number[];
  high: number[];
  radius: number; // of particles without one of their own (m)
  species: { name: string; color: string }[];
  liquid: Tank | null; // of a liquid, which is drawn as a continuous region
  apart: number | null; // the species from which on particles keep their own colors
  colorings: Coloring[];
  usual: string; // the coloring to begin with
  numbers: { name: string; unit: string }[];
  shown: string[]; // the numbers whose curves are shown at first
  outlines: Polyline[];
  painted: (string | null)[]; // the colors of what moves, line by line; null or left out: as walls are
  sheet: Sheet | null;
  linked: boolean;
  widest: number; // the gap up to which films are drawn (m)
  maps: Record<string, string>; // 256 colors each, base64 of RGB
  dark: Record<string, string>; // those that are taken on a dark page, where they differ
  facts: [string, string][];
  papers: { key: string; text: string }[];
  scene: string;
  live: boolean;
}

export interface Link {
  x: Float32Array; // (C, d) one end
  along: Float32Array; // (C, d) from there to the other
  gap: Float32Array;
  tension: Float32Array;
}

/** One instant, in meters and in the recorded units. */
export interface Instant {
  time: number;
  count: number;
  position: Float32Array; // (N, d)
  arrays: Record<string, Float32Array>;
  movers: Float32Array[];
  links: Link | null;
  sheet: Float32Array | null;
}

type Raw = Uint8Array | Uint16Array | Uint32Array | Float32Array;

/** Numbers from their differences from row to row: folded, so that small ones are small, all low bytes first. */
export function summed(bytes: Uint8Array, rows: number): Uint16Array {
  const size = bytes.length / 2;
  const width = size / rows;
  const found = new Uint16Array(size);
  for (let at = 0; at < size; at++) {
    const folded = bytes[at] | (bytes[size + at] << 8);
    found[at] = (at < width ? 0 : found[at - width]) + ((folded >>> 1) ^ -(folded & 1));
  }
  return found;
}

export class Chunk {
  private readonly whole = new Map<string, Uint16Array>();
  private readonly steady = new Map<string, Float32Array>();
  private readonly starts: number[] = [0];
  private readonly linkStarts: number[] = [0];

  constructor(
    readonly header: ChunkHeader,
    private readonly bytes: ArrayBuffer,
    private readonly dimension: number,
  ) {
    for (const count of header.counts) this.starts.push(this.starts[this.starts.length - 1] + count);
    for (const count of header.links) this.linkStarts.push(this.linkStarts[this.linkStarts.length - 1] + count);
    for (const [name, { offset, length, rows }] of Object.entries(header.places)) {
      if (rows) this.whole.set(name, summed(new Uint8Array(bytes, offset, 2 * length), rows));
    }
  }

  get frames(): number {
    return this.header.times.length;
  }

  /** A number of all frames. */
  numbers(name: string): Float32Array {
    return this.raw(`number/${name}`) as Float32Array;
  }

  instant(index: number): Instant {
    const { header } = this;
    const arrays: Record<string, Float32Array> = {};
    for (const name of Object.keys(header.places)) {
      if (name.startsWith("array/")) arrays[name.slice(6)] = this.particles(name, index, 1);
    }
    return {
      time: header.times[index],
      count: header.counts[index],
      position: this.particles("position", index, this.dimension),
      arrays,
      movers: this.movers(index),
      links: this.links(index),
      sheet: this.sheet(index),
    };
  }

  range(name: string): [number, number] | undefined {
    return this.header.scales[name] ?? this.header.ranges[name];
  }

  private raw(name: string): Raw {
    const found = this.whole.get(name);
    if (found) return found;
    const { offset, length, kind } = this.header.places[name];
    const make = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, f4: Float32Array }[kind];
    return new make(this.bytes, offset, length);
  }

  private particles(name: string, index: number, width: number): Float32Array {
    const steady = this.header.steady.includes(name);
    const known = steady ? this.steady.get(name) : undefined;
    if (known) return known;
    const begin = steady ? 0 : this.starts[index];
    const found = this.real(name, width * begin, width * (begin + this.header.counts[index]));
    if (steady) this.steady.set(name, found);
    return found;
  }

  /** Quantized numbers back in their units. */
  private real(name: string, begin: number, end: number): Float32Array {
    const raw = this.raw(name).subarray(begin, end);
    if (raw instanceof Float32Array) return raw;
    const [low, high] = this.header.ranges[name] ?? [0, this.top(name)];
    const step = (high - low) / this.top(name);
    return Float32Array.from(raw as Uint16Array, (value) => low + step * value);
  }

  private top(name: string): number {
    return { u1: 255, u2: 65535, u4: 4294967295, f4: 1 }[this.header.places[name].kind];
  }

  private movers(index: number): Float32Array[] {
    const found: Float32Array[] = [];
    const size = this.header.movers.reduce((sum, points) => sum + points, 0) * this.dimension;
    let begin = index * size;
    for (const points of this.header.movers) {
      const end = begin + points * this.dimension;
      found.push((this.raw("movers") as Float32Array).subarray(begin, end));
      begin = end;
    }
    return found;
  }

  private links(index: number): Link | null {
    if (!("links/pairs" in this.header.places)) return null;
    const [begin, end, d] = [this.linkStarts[index], this.linkStarts[index + 1], this.dimension];
    const position = this.particles("position", index, d);
    const pairs = this.raw("links/pairs").subarray(2 * begin, 2 * end);
    const [ways, across] = [this.raw("links/ways").subarray(begin, end), this.raw("links/across")];
    const most = across.length / this.frames / d; // ways that each frame tells
    const [x, along] = [new Float32Array(d * ways.length), new Float32Array(d * ways.length)];
    for (let c = 0; c < ways.length; c++) {
      for (let k = 0; k < d; k++) {
        x[d * c + k] = position[d * pairs[2 * c] + k];
        along[d * c + k] = position[d * pairs[2 * c + 1] + k] - x[d * c + k] + across[d * (most * index + ways[c]) + k];
      }
    }
    const [gap, tension] = [this.real("links/gap", begin, end).map(Math.exp), this.real("links/tension", begin, end)];
    return { x, along, gap, tension };
  }

  private sheet(index: number): Float32Array | null {
    if (!("sheet" in this.header.places)) return null;
    const size = this.header.places["sheet"].length / this.frames;
    return this.real("sheet", index * size, (index + 1) * size);
  }
}

export class Run {
  readonly chunks: Chunk[] = [];
  readonly times: number[] = [];
  private readonly cache = new Map<number, Instant>();

  constructor(readonly header: RunHeader) {}

  append(chunk: Chunk): void {
    this.chunks.push(chunk);
    this.times.push(...chunk.header.times);
  }

  get frames(): number {
    return this.times.length;
  }

  instant(index: number): Instant {
    let found = this.cache.get(index);
    if (!found) {
      if (this.cache.size > 3) this.cache.clear();
      found = this.located(index);
      this.cache.set(index, found);
    }
    return found;
  }

  /** A number of all frames, chunk after chunk. */
  numbers(name: string): number[] {
    return this.chunks.flatMap((chunk) => Array.from(chunk.numbers(name)));
  }

  /** Between which values nearly all lie. */
  range(name: string): [number, number] {
    const ends = this.chunks.map((chunk) => chunk.range(name)).filter((range) => range !== undefined);
    if (!ends.length) return [0, 1];
    return [Math.min(...ends.map((range) => range[0])), Math.max(...ends.map((range) => range[1]))];
  }

  private located(index: number): Instant {
    let local = index;
    for (const chunk of this.chunks) {
      if (local < chunk.frames) return chunk.instant(local);
      local -= chunk.frames;
    }
    throw new RangeError(`no frame ${index}`);
  }
}
