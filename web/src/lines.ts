// Lines some pixels wide: walls, rims, bodies, forces, films.

import type { Eye } from "./camera";
import { type GL, Program, Rows, square } from "./gl";

const VERTEX = `
uniform mat4 matrix;
uniform vec2 canvas; // pixels
in vec2 corner;
in vec3 first, second;
in vec4 color;
in float width; // pixels
out vec4 painted_as;
void main() {
  vec4 a = matrix * vec4(first, 1.0), b = matrix * vec4(second, 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * canvas;
  float length_ = length(along);
  vec2 unit = length_ > 1e-6 ? along / length_ : vec2(1.0, 0.0);
  vec2 shift = (vec2(-unit.y, unit.x) * corner.y + unit * corner.x * 0.5) * width / canvas;
  vec4 end = corner.x < 0.0 ? a : b;
  gl_Position = vec4(end.xy + shift * end.w, end.zw);
  painted_as = color;
}`;

const FRAGMENT = `
in vec4 painted_as;
out vec4 painted;
void main() { painted = painted_as; }`;

const ROW = 11; // two ends, a color, a width

/** Segments that are collected and then drawn at once. */
export class Segments {
  private values: number[] = [];

  add(first: ArrayLike<number>, second: ArrayLike<number>, color: number[], width: number): void {
    this.values.push(first[0], first[1], first.length > 2 ? first[2] : 0);
    this.values.push(second[0], second[1], second.length > 2 ? second[2] : 0, ...color, width);
  }

  /** Points one after the other, back to the first where the line is closed. */
  path(points: ArrayLike<number>[], closed: boolean, color: number[], width: number): void {
    for (let place = 1; place < points.length; place++) this.add(points[place - 1], points[place], color, width);
    if (closed && points.length > 2) this.add(points[points.length - 1], points[0], color, width);
  }

  get rows(): Float32Array {
    return new Float32Array(this.values);
  }
}

export class Lines {
  private readonly program: Program;
  private readonly corners: Rows;
  private readonly rows: Rows;
  private readonly state: WebGLVertexArrayObject;
  private count = 0;

  constructor(private readonly gl: GL) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.state = gl.createVertexArray()!;
    gl.bindVertexArray(this.state);
    this.corners = square(gl);
    this.rows = new Rows(gl);
  }

  fill(segments: Segments): void {
    const values = segments.rows;
    this.count = values.length / ROW;
    if (!this.count) return;
    this.gl.bindVertexArray(this.state);
    this.rows.fill(values);
    const at = (name: string): number => this.program.attribute(name);
    this.corners.feed(at("corner"), 2, 2, 0, 0);
    this.rows.feed(at("first"), 3, ROW, 0);
    this.rows.feed(at("second"), 3, ROW, 3);
    this.rows.feed(at("color"), 4, ROW, 6);
    this.rows.feed(at("width"), 1, ROW, 10);
  }

  draw(eye: Eye, width: number, height: number): void {
    if (!this.count) return;
    const { gl, program } = this;
    gl.bindVertexArray(this.state);
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("canvas", width, height);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}
