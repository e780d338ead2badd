// The picture of a tank from the side: walls, what stands in it, and the liquid's particles, leaning as the tank leans.

import type { Poured } from "./asking";
import { bytes } from "./toy";

export interface Basin {
  title: string;
  low: [number, number];
  high: [number, number];
  view: [number, number, number, number]; // left, bottom, right, top: what places are told in
  walls: [boolean, boolean, boolean, boolean]; // left, right, bottom, top
  movable: boolean;
  pushed: number; // how far the left wall can go (m)
  radius: number;
  speeds: number[];
  steepest: number;
  colorings: [string, string, string][]; // name, unit, map
}

const SHADES = 64;
const FINEST = 65535;
const ROOM = 0.06; // around the tank, over its width

/** Words of two bytes, the lower one first. */
function words(coded: string): Uint16Array {
  return new Uint16Array(bytes(coded).buffer as ArrayBuffer);
}

export class Picture {
  private readonly on: CanvasRenderingContext2D;
  private readonly dots = document.createElement("canvas");
  private dotted = "";
  private scale = 1; // pixels a meter

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly basin: Basin,
  ) {
    this.on = canvas.getContext("2d")!;
  }

  /** Pixels a meter with which all of a view that leans so far is seen; its middle is in the middle of the canvas. */
  private fitting(leaning: number): number {
    const [left, bottom, right, top] = this.basin.view;
    const room = 2 * ROOM * (right - left);
    const [width, height, c, s] = [right - left, top - bottom, Math.cos(leaning), Math.abs(Math.sin(leaning))];
    const [across, up] = [c * width + s * height + room, s * width + c * height + room];
    return Math.min(this.canvas.width / across, this.canvas.height / up);
  }

  private get middle(): [number, number] {
    const [left, bottom, right, top] = this.basin.view;
    return [(left + right) / 2, (bottom + top) / 2];
  }

  /** Where a pointer is in the tank that leans so far (m). */
  at(event: { clientX: number; clientY: number }, leaning: number): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    const fine = this.canvas.width / box.width;
    const scale = this.fitting(leaning);
    const across = ((event.clientX - box.left) * fine - this.canvas.width / 2) / scale;
    const up = (this.canvas.height / 2 - (event.clientY - box.top) * fine) / scale;
    const [c, s] = [Math.cos(leaning), Math.sin(leaning)];
    return [this.middle[0] + c * across - s * up, this.middle[1] + s * across + c * up];
  }

  draw(seen: Poured): void {
    const { canvas, on } = this;
    const fine = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * fine), Math.round(canvas.clientHeight * fine)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const scale = (this.scale = this.fitting(seen.leaning));
    on.setTransform(1, 0, 0, 1, 0, 0);
    on.clearRect(0, 0, width, height);
    on.translate(width / 2, height / 2);
    on.rotate(seen.leaning);
    on.translate(-scale * this.middle[0], scale * this.middle[1]);
    this.inside(seen);
    this.liquid(seen);
    this.solids(seen, fine);
    this.walls(seen, fine);
  }

  /** A ground on which the darkest liquid is seen, and the brightest. */
  private inside({ wall }: Poured): void {
    const { on, basin } = this;
    const [[left, bottom], [right, top]] = [basin.low, basin.high];
    this.path([[left + wall, bottom], [right, bottom], [right, top], [left + wall, top]]); // prettier-ignore
    on.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--inside");
    on.fill();
  }

  private liquid(seen: Poured): void {
    const { on, scale } = this;
    const [left, bottom, right, top] = this.basin.view;
    const size = this.paint(seen.coloring);
    const [places, colors] = [words(seen.places), bytes(seen.colors)];
    for (let one = 0; one < colors.length; one++) {
      const x = left + ((right - left) * places[2 * one]) / FINEST;
      const y = bottom + ((top - bottom) * places[2 * one + 1]) / FINEST;
      const shade = Math.min(SHADES - 1, (colors[one] * SHADES) >> 8);
      on.drawImage(this.dots, shade * size, 0, size, size, scale * x - size / 2, -scale * y - size / 2, size, size);
    }
  }

  /** A row of dots, one of each shade, for this scale; how wide each is. */
  private paint(coloring: string): number {
    const radius = this.scale * this.basin.radius;
    const size = Math.ceil(2 * radius) + 2;
    const wanted = `${coloring} ${radius}`;
    if (wanted === this.dotted) return size;
    this.dotted = wanted;
    const map = bytes(this.basin.colorings.find(([name]) => name === coloring)![2]);
    [this.dots.width, this.dots.height] = [SHADES * size, size];
    const on = this.dots.getContext("2d")!;
    for (let shade = 0; shade < SHADES; shade++) {
      const color = 3 * Math.round((255 * shade) / (SHADES - 1));
      on.fillStyle = `rgb(${map[color]}, ${map[color + 1]}, ${map[color + 2]})`;
      on.beginPath();
      on.arc((shade + 0.5) * size, size / 2, radius, 0, 2 * Math.PI);
      on.fill();
    }
    return size;
  }

  private path(points: [number, number][]): void {
    const { on, scale } = this;
    on.beginPath();
    for (const [x, y] of points) on.lineTo(scale * x, -scale * y);
  }

  private solids({ solids }: Poured, fine: number): void {
    const { on } = this;
    const style = getComputedStyle(document.documentElement);
    for (const corners of solids) {
      this.path(corners);
      on.closePath();
      on.fillStyle = style.getPropertyValue("--solid");
      on.fill();
      on.strokeStyle = style.getPropertyValue("--rim");
      on.lineWidth = 2 * fine;
      on.stroke();
    }
  }

  /** The walls; one that can be pushed is broader, and its handle stands above the tank. */
  private walls({ wall }: Poured, fine: number): void {
    const { on, basin } = this;
    const [[left, bottom], [right, top]] = [basin.low, basin.high];
    const style = getComputedStyle(document.documentElement);
    const sides: [number, number][][] = [
      [[left + wall, bottom], [left + wall, top]],
      [[right, bottom], [right, top]],
      [[left, bottom], [right, bottom]],
      [[left, top], [right, top]],
    ]; // prettier-ignore
    for (const [number, ends] of sides.entries()) {
      if (!basin.walls[number]) continue;
      const pushed = number === 0 && basin.movable;
      this.path(ends);
      on.strokeStyle = style.getPropertyValue(pushed ? "--accent" : "--rim");
      on.lineWidth = (pushed ? 8 : 4) * fine;
      on.lineCap = "round";
      on.stroke();
    }
  }
}
