// Where the eye is: above a plane that can be moved and enlarged, or around a middle point in space.

type Vector = [number, number, number];

export interface Eye {
  matrix: Float32Array; // clip space from meters, column by column
  right: Vector;
  up: Vector;
  toward: Vector;
  pixel: number; // meters that a pixel spans, at the middle
  place: Vector; // where the eye is (3D)
  slope: [number, number]; // of rays to the edges of the canvas, across and up (3D)
}

const NEAREST = 1e-3;
const FIELD = 0.5; // of view, radians
const STEEPEST = 1.55;

export class Camera {
  private readonly home: { middle: Vector; span: number };
  private middle: Vector;
  private zoom = 1;
  azimuth = 0.5;
  elevation = 0.35;

  constructor(
    private readonly dimension: 2 | 3,
    private readonly low: number[],
    private readonly high: number[],
    private readonly upward: "y" | "z",
  ) {
    const middle: Vector = [0, 0, 0];
    for (let k = 0; k < low.length; k++) middle[k] = (low[k] + high[k]) / 2;
    this.home = { middle, span: Math.hypot(...high.map((value, k) => value - low[k])) };
    this.middle = [...middle];
  }

  reset(): void {
    this.middle = [...this.home.middle];
    this.zoom = 1;
    [this.azimuth, this.elevation] = [0.5, 0.35];
  }

  /** Closer (above 1) or farther, about a point of the canvas given from -1 to 1 in both directions. */
  closer(factor: number, x: number, y: number, aspect: number): void {
    const before = this.half(aspect);
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.05), 1e4);
    if (this.dimension === 3) return;
    const after = this.half(aspect);
    this.middle[0] += x * (before[0] - after[0]);
    this.middle[1] += y * (before[1] - after[1]);
  }

  /** A pull at the picture, in pixels. */
  drag(dx: number, dy: number, turning: boolean, height: number): void {
    if (this.dimension === 3 && turning) {
      this.azimuth -= (3 * dx) / height;
      this.elevation = Math.min(Math.max(this.elevation + (3 * dy) / height, -STEEPEST), STEEPEST);
      return;
    }
    const eye = this.eye(1, height);
    for (let k = 0; k < 3; k++) this.middle[k] += eye.pixel * (dy * eye.up[k] - dx * eye.right[k]);
  }

  follow(place: ArrayLike<number>): void {
    for (let k = 0; k < place.length; k++) this.middle[k] = place[k];
  }

  /** What the canvas spans from its middle to its edges (m), in the plane. */
  private half(aspect: number): [number, number] {
    const [width, height] = [this.high[0] - this.low[0], this.high[1] - this.low[1]];
    const tall = Math.max(height, width / aspect) * 0.53;
    return [(tall * aspect) / this.zoom, tall / this.zoom];
  }

  eye(aspect: number, height: number): Eye {
    return this.dimension === 2 ? this.above(aspect, height) : this.around(aspect, height);
  }

  private above(aspect: number, height: number): Eye {
    const [x, y] = this.half(aspect);
    const deep = 1 / this.home.span;
    const m = this.middle;
    const matrix = new Float32Array([1 / x, 0, 0, 0, 0, 1 / y, 0, 0, 0, 0, -deep, 0, -m[0] / x, -m[1] / y, 0, 1]);
    return { matrix, right: [1, 0, 0], up: [0, 1, 0], toward: [0, 0, 1], pixel: (2 * y) / height, place: [...m], slope: [0, 0] };
  }

  /** A direction, given where y points up. */
  private turned([x, y, z]: Vector): Vector {
    return this.upward === "z" ? [x, -z, y] : [x, y, z];
  }

  /** In perspective. */
  private around(aspect: number, height: number): Eye {
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const right = this.turned([ca, 0, -sa]);
    const toward = this.turned([ce * sa, se, ce * ca]);
    const up = this.turned([-se * sa, ce, -se * ca]);
    const slope = Math.tan(FIELD / 2);
    const distance = (0.55 * this.home.span) / (slope * this.zoom * Math.min(1, aspect));
    const eye = this.middle.map((value, k) => value + distance * toward[k]) as Vector;
    const [near, far] = [Math.max(distance - this.home.span, NEAREST * distance), distance + this.home.span];
    const matrix = projected([right, up, toward], eye, [1 / (slope * aspect), 1 / slope], [near, far]);
    return { matrix, right, up, toward, pixel: (2 * distance * slope) / height, place: eye, slope: [slope * aspect, slope] };
  }
}

function projected(axes: Vector[], eye: Vector, scale: [number, number], depth: [number, number]): Float32Array {
  const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const [right, up, toward] = axes;
  const [near, far] = depth;
  const [a, b] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
  const matrix = new Float32Array(16);
  for (let k = 0; k < 3; k++) {
    matrix[4 * k] = scale[0] * right[k];
    matrix[4 * k + 1] = scale[1] * up[k];
    matrix[4 * k + 2] = a * toward[k];
    matrix[4 * k + 3] = -toward[k];
  }
  matrix[12] = -scale[0] * dot(right, eye);
  matrix[13] = -scale[1] * dot(up, eye);
  matrix[14] = -a * dot(toward, eye) + b;
  matrix[15] = dot(toward, eye);
  return matrix;
}

/** Where a point is on the canvas, from -1 to 1 in both directions. */
export function onCanvas(eye: Eye, place: ArrayLike<number>): [number, number, number] {
  const [x, y, z] = [place[0], place[1], place.length > 2 ? place[2] : 0];
  const m = eye.matrix;
  const out = [0, 1, 2, 3].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row]);
  return [out[0] / out[3], out[1] / out[3], out[2] / out[3]];
}
