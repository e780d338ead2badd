// The picture of the bowl: the liquid's height as color, the dish, the floats as lit balls.

import type { Now } from "./asking";
import type { Outline } from "./chapters";
import { bytes } from "./toy";

/** What a page of a bowl is told once. */
export interface Bowl extends Outline {
  title: string;
  grid: number;
  shelf: { name: string; color: string; radius: number }[];
  speeds: number[];
  steepest: number;
  map: string;
}

/** A color of the page as it is now, dark or light. */
export function shade(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`);
}

/** A ball with light from the upper left. */
export function ball(on: CanvasRenderingContext2D, x: number, y: number, radius: number, color: string): void {
  const light = on.createRadialGradient(x - 0.35 * radius, y - 0.35 * radius, 0.1 * radius, x, y, radius);
  light.addColorStop(0, `color-mix(in srgb, ${color} 55%, white)`);
  light.addColorStop(0.6, color);
  light.addColorStop(1, `color-mix(in srgb, ${color} 65%, black)`);
  on.fillStyle = light;
  on.beginPath();
  on.arc(x, y, radius, 0, 2 * Math.PI);
  on.fill();
}

export function millimeters(length: number): string {
  return `${(1e3 * length).toFixed(2)} mm`;
}

export class Picture {
  private readonly on: CanvasRenderingContext2D;
  private readonly sheet = document.createElement("canvas");
  private readonly colors: Uint8Array;
  private painted = "";

  constructor(
    private readonly canvas: HTMLCanvasElement,
    public bowl: Outline & Pick<Bowl, "grid" | "map">,
  ) {
    this.on = canvas.getContext("2d")!;
    this.colors = bytes(bowl.map);
  }

  /** Pixels a meter, and where the middle is. */
  private get place(): { scale: number; x: number; y: number } {
    const [left, right, bottom, top] = this.bowl.view;
    const { width, height } = this.canvas;
    const scale = Math.min(width / (right - left), height / (top - bottom));
    return { scale, x: width / 2 - (scale * (left + right)) / 2, y: height / 2 + (scale * (bottom + top)) / 2 };
  }

  /** Where a pointer is in the bowl (m). */
  at(event: { clientX: number; clientY: number }): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    const fine = this.canvas.width / box.width;
    const { scale, x, y } = this.place;
    return [((event.clientX - box.left) * fine - x) / scale, (y - (event.clientY - box.top) * fine) / scale];
  }

  draw(now: Now): void {
    const { canvas, on } = this;
    const fine = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * fine), Math.round(canvas.clientHeight * fine)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    on.clearRect(0, 0, width, height);
    this.liquid(now);
    const { scale, x, y } = this.place;
    for (let one = 0; one < now.x.length; one++) {
      const kind = now.kinds[now.species[one]];
      ball(on, x + scale * now.x[one], y - scale * now.y[one], scale * now.radius[one], kind.color);
    }
  }

  /** A line of this color, on an edge that sets it off from whatever lies below. */
  private drawn(color: string, wide: number, path: () => void): void {
    const { on } = this;
    const fine = window.devicePixelRatio || 1;
    on.beginPath();
    path();
    on.lineJoin = "round";
    for (const [style, width] of [[shade("inside"), wide + 2], [color, wide]] as const) {
      [on.strokeStyle, on.lineWidth] = [style, width * fine];
      on.stroke();
    }
  }

  /** The forces on all floats; the longest arrow is as long as a tenth of the view. */
  arrows(now: Now): void {
    const { on } = this;
    const { force } = now;
    const { scale, x, y } = this.place;
    const most = Math.max(1e-12, ...now.x.map((_, one) => Math.hypot(force[2 * one], force[2 * one + 1])));
    const long = (0.1 * scale * (this.bowl.view[1] - this.bowl.view[0])) / most;
    const head = 4 * (window.devicePixelRatio || 1);
    this.drawn(shade("arrow"), 2, () => {
      for (let one = 0; one < now.x.length; one++) {
        const [along, down] = [long * force[2 * one], -long * force[2 * one + 1]];
        const length = Math.hypot(along, down);
        if (length < head) continue;
        const [ux, uy] = [(head * along) / length, (head * down) / length];
        const [endX, endY] = [x + scale * now.x[one] + along, y - scale * now.y[one] + down];
        on.moveTo(endX - along, endY - down);
        on.lineTo(endX, endY);
        on.moveTo(endX - 2 * ux - uy, endY - 2 * uy + ux);
        on.lineTo(endX, endY);
        on.lineTo(endX - 2 * ux + uy, endY - 2 * uy - ux);
      }
    });
  }

  /** A line between the centers of two floats, with their distance. */
  ruler(now: Now, [one, other]: [number, number]): void {
    const { on } = this;
    const { scale, x, y } = this.place;
    const fine = window.devicePixelRatio || 1;
    const ends = [one, other].map((each) => [x + scale * now.x[each], y - scale * now.y[each]]);
    this.drawn(shade("accent"), 2, () => ends.forEach(([right, down]) => on.lineTo(right, down)));
    const text = millimeters(Math.hypot(now.x[one] - now.x[other], now.y[one] - now.y[other]));
    on.font = `600 ${14 * fine}px system-ui`;
    const wide = on.measureText(text).width + 10 * fine;
    const left = Math.min(Math.max(ends[0][0], ends[1][0]) + 10 * fine, this.canvas.width - wide);
    const middle = (ends[0][1] + ends[1][1]) / 2;
    on.fillStyle = shade("panel");
    on.fillRect(left, middle - 11 * fine, wide, 22 * fine);
    on.fillStyle = shade("ink");
    on.fillText(text, left + 5 * fine, middle + 5 * fine);
  }

  /** A ring around a float. */
  ring(now: Now, one: number): void {
    const { scale, x, y } = this.place;
    this.drawn(shade("accent"), 3, () => this.on.arc(x + scale * now.x[one], y - scale * now.y[one], 1.25 * scale * now.radius[one], 0, 2 * Math.PI));
  }

  private liquid(now: Now): void {
    const { on } = this;
    const { scale, x, y } = this.place;
    if (now.surface !== this.painted) this.paint(now.surface);
    on.save();
    on.beginPath();
    for (const [right, up] of this.bowl.outline) on.lineTo(x + scale * right, y - scale * up);
    on.closePath();
    on.clip();
    const [left, right, bottom, top] = this.bowl.view;
    if (!this.painted && now.color) {
      on.fillStyle = now.color;
      on.fill();
    }
    if (this.painted) on.drawImage(this.sheet, x + scale * left, y - scale * top, scale * (right - left), scale * (top - bottom));
    // A slope against the dish shows as light from one side.
    const far = Math.hypot(...now.slope);
    if (far > 1e-3) {
      const reach = (scale * (right - left)) / 2;
      const [ux, uy] = [now.slope[0] / far, -now.slope[1] / far];
      const shade = on.createLinearGradient(x - ux * reach, y - uy * reach, x + ux * reach, y + uy * reach);
      const strong = Math.min(0.5, 2 * far);
      shade.addColorStop(0, `rgba(0, 20, 50, ${strong})`);
      shade.addColorStop(0.5, "rgba(128, 128, 128, 0)");
      shade.addColorStop(1, `rgba(255, 255, 255, ${strong})`);
      on.fillStyle = shade;
      on.fillRect(x - reach, y - reach, 2 * reach, 2 * reach);
    }
    on.restore();
    on.strokeStyle = shade("rim");
    on.lineWidth = 3 * (window.devicePixelRatio || 1);
    on.stroke();
  }

  private paint(surface: string): void {
    this.painted = surface;
    if (!surface) return;
    const heights = bytes(surface);
    const rows = Math.round(heights.length / this.bowl.grid) || 1;
    const columns = heights.length / rows;
    [this.sheet.width, this.sheet.height] = [columns, rows];
    const image = new ImageData(columns, rows);
    for (let cell = 0; cell < heights.length; cell++) {
      const color = 3 * heights[cell];
      image.data.set([this.colors[color], this.colors[color + 1], this.colors[color + 2], 255], 4 * cell);
    }
    this.sheet.getContext("2d")!.putImageData(image, 0, 0);
  }
}
