// The picture of a tank from the side: walls, what stands in it, and the liquid's particles, leaning as the tank leans.

import type { Poured } from "./asking";
import { regionOf, SLOPE, type Tank } from "./liquid";
import { bytes, themed } from "./toy";

export interface Basin {
  title: string;
  low: [number, number];
  high: [number, number];
  view: [number, number, number, number]; // left, bottom, right, top: what places are told in
  walls: [boolean, boolean, boolean, boolean]; // left, right, bottom, top
  movable: boolean;
  pushed: number; // how far the left wall can go (m)
  spacing: number; // of the particles (m)
  speeds: number[];
  steepest: number;
  colorings: [string, string, string, string][]; // name, unit, map, map for a dark page
}

export const FINEST = 65535; // steps across the view
const ALONE = 0.4; // the radius of a single particle, in spacings
const MOST_PIXELS = 6; // of a cell of the grid, along a side
const ROOM = 0.06; // around the tank, over its width

/** Words of two bytes, the lower one first. */
export function words(coded: string): Uint16Array {
  return new Uint16Array(bytes(coded).buffer as ArrayBuffer);
}

/** A color as the page's style has it, from 0 to 255. */
function channels(color: string): [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

export class Picture {
  private readonly on: CanvasRenderingContext2D;
  private readonly region = document.createElement("canvas");
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

  /** A cross at a place of the tank, as it leans in the last picture. */
  cross([x, y]: [number, number]): void {
    const { on, scale } = this;
    const [right, down, arm] = [scale * x, -scale * y, 8 * (window.devicePixelRatio || 1)];
    on.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--accent");
    on.lineWidth = arm / 4;
    on.beginPath();
    on.moveTo(right - arm, down);
    on.lineTo(right + arm, down);
    on.moveTo(right, down - arm);
    on.lineTo(right, down + arm);
    on.stroke();
  }

  /** The ground of the tank. */
  private inside({ wall }: Poured): void {
    const { on, basin } = this;
    const [[left, bottom], [right, top]] = [basin.low, basin.high];
    this.path([[left + wall, bottom], [right, bottom], [right, top], [left + wall, top]]); // prettier-ignore
    on.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--inside");
    on.fill();
  }

  /** The region that the particles fill, colored, with a line along its surface; single ones are discs below it. */
  private liquid(seen: Poured): void {
    const { basin, on, scale } = this;
    const [left, bottom, right, top] = basin.view;
    const [places, colors] = [words(seen.places), bytes(seen.colors)];
    const [place, shade] = [new Float32Array(3 * colors.length), Float32Array.from(colors, (value) => value / 255)];
    const map = this.map(seen.coloring);
    for (let one = 0; one < colors.length; one++) {
      const x = (place[3 * one] = left + ((right - left) * places[2 * one]) / FINEST);
      const y = (place[3 * one + 1] = bottom + ((top - bottom) * places[2 * one + 1]) / FINEST);
      const color = 3 * colors[one];
      on.fillStyle = `rgb(${map[color]}, ${map[color + 1]}, ${map[color + 2]})`;
      on.beginPath();
      on.arc(scale * x, -scale * y, ALONE * scale * basin.spacing, 0, 2 * Math.PI);
      on.fill();
    }
    const high: [number, number] = [basin.high[0], basin.walls[3] ? basin.high[1] : top];
    const tank: Tank = { spacing: basin.spacing, low: [basin.low[0] + seen.wall, basin.low[1]], high, periodic: [false, false] };
    this.paint(tank, place, shade, map);
    on.drawImage(this.region, scale * tank.low[0], -scale * high[1], scale * (high[0] - tank.low[0]), scale * (high[1] - tank.low[1]));
  }

  /** The colors of a quantity, for a light or a dark page. */
  private map(coloring: string): Uint8Array {
    const [, , light, dark] = this.basin.colorings.find(([name]) => name === coloring)!;
    return bytes(themed([light, dark]));
  }

  /** The liquid as pixels, from the sum of kernels and the mean shades of its particles. */
  private paint(tank: Tank, place: Float32Array, shade: Float32Array, map: Uint8Array): void {
    const { counts, cells } = regionOf(tank, place, shade, () => true);
    const [columns, rows] = counts;
    const pixels = Math.min(MOST_PIXELS, Math.max(1, Math.ceil((this.scale * (tank.high[0] - tank.low[0])) / columns)));
    const [width, height] = [columns * pixels, rows * pixels];
    [this.region.width, this.region.height] = [width, height];
    const line = channels(getComputedStyle(document.documentElement).getPropertyValue("--rim").trim());
    const image = new ImageData(width, height);
    const steep = (SLOPE * (tank.high[0] - tank.low[0])) / (tank.spacing * width); // of the sum at an edge, per pixel
    for (let row = 0; row < height; row++) {
      const y = Math.min(Math.max((height - row - 0.5) / pixels - 0.5, 0), rows - 1.001);
      const up = y - Math.floor(y);
      for (let column = 0; column < width; column++) {
        const x = Math.min(Math.max((column + 0.5) / pixels - 0.5, 0), columns - 1.001);
        const [at, part] = [2 * (Math.floor(y) * columns + Math.floor(x)), x - Math.floor(x)];
        const between = (k: number): number =>
          (1 - up) * ((1 - part) * cells[at + k] + part * cells[at + 2 + k]) +
          up * ((1 - part) * cells[at + 2 * columns + k] + part * cells[at + 2 * columns + 2 + k]);
        const inside = (between(0) - 0.5) / steep;
        if (inside < -0.7) continue;
        const color = 3 * Math.round(255 * Math.min(Math.max(between(1), 0), 1));
        const edge = 0.8 * Math.min(Math.max(1.5 - Math.abs(inside), 0), 1);
        const to = 4 * (row * width + column);
        for (let k = 0; k < 3; k++) image.data[to + k] = (1 - edge) * map[color + k] + edge * line[k];
        image.data[to + 3] = 255 * Math.min(inside + 0.7, 1);
      }
    }
    this.region.getContext("2d")!.putImageData(image, 0, 0);
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
