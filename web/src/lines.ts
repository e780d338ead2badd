// Lines some pixels wide: walls, rims, bodies, forces, films.

import type { Eye } from "./camera";
import { type GL, Program, SQUARES, Table } from "./gl";

const VERTEX = `${SQUARES}
uniform mat4 matrix;
uniform vec2 canvas; // pixels
out vec4 painted_as;
void main() {
  vec4 first = numbers(3, 0), second = numbers(3, 1);
  vec2 corner = corner_of();
  float width = first.w; // pixels
  vec4 a = matrix * vec4(first.xyz, 1.0), b = matrix * vec4(second.xyz, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * canvas;
  float length_ = length(along);
  vec2 unit = length_ > 1e-6 ? along / length_ : vec2(1.0, 0.0);
  vec2 shift = (vec2(-unit.y, unit.x) * corner.y + unit * corner.x * 0.5) * width / canvas;
  vec4 end = corner.x < 0.0 ? a : b;
  gl_Position = vec4(end.xy + shift * end.w, end.zw);
  painted_as = numbers(3, 2);
}`;

const FRAGMENT = `
in vec4 painted_as;
out vec4 painted;
void main() { painted = painted_as; }`;

const ROW = 12; // one end, a width, the other end, nothing, a color

/** Segments that are collected and then drawn at once. */
export class Segments {
  readonly values: number[] = [];

  add(first: ArrayLike<number>, second: ArrayLike<number>, color: number[], width: number): void {
    this.values.push(first[0], first[1], first.length > 2 ? first[2] : 0, width);
    this.values.push(second[0], second[1], second.length > 2 ? second[2] : 0, 0, color[0], color[1], color[2], color[3]);
  }

  /** Points one after the other, back to the first where the line is closed. */
  path(points: ArrayLike<number>[], closed: boolean, color: number[], width: number): void {
    for (let place = 1; place < points.length; place++) this.add(points[place - 1], points[place], color, width);
    if (closed && points.length > 2) this.add(points[points.length - 1], points[0], color, width);
  }
}

export class Lines {
  private readonly program: Program;
  private readonly table: Table;
  private count = 0;

  constructor(gl: GL) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.table = new Table(gl, 3);
  }

  fill({ values }: Segments): void {
    this.count = values.length / ROW;
    this.table.rows(this.count).set(values);
    this.table.send();
  }

  draw(eye: Eye, width: number, height: number): void {
    if (!this.count) return;
    const { program } = this;
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("canvas", width, height);
    this.table.draw(program, 0);
  }
}
