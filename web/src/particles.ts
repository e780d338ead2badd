// Spheres and discs as squares that face the eye, shaded in the fragment program.

import type { Eye } from "./camera";
import { Colors, type GL, Program, SQUARES, Table } from "./gl";

const VERTEX = `${SQUARES}
uniform mat4 matrix;
uniform vec3 right, up, toward;
uniform float part;
out vec2 inside;
out float color, depth_slope;
flat out float index;
void main() {
  vec4 here = numbers(2, 0), before = numbers(2, 1);
  float radius = here.w, shade = before.w;
  vec3 middle = mix(before.xyz, here.xyz, part);
  inside = corner_of();
  gl_Position = matrix * vec4(middle + radius * (inside.x * right + inside.y * up), 1.0);
  vec4 front = matrix * vec4(middle + radius * toward, 1.0);
  vec4 center = matrix * vec4(middle, 1.0);
  depth_slope = 0.5 * (front.z / front.w - center.z / center.w);
  color = shade;
  index = float(square_number());
}`;

const FRAGMENT = `
uniform sampler2D colors;
uniform vec4 rim; // color, and whether the picture is flat
uniform float edge; // a pixel, in radii of the smallest particle that is drawn with a rim
uniform float chosen;
in vec2 inside;
in float color, depth_slope;
flat in float index;
out vec4 painted;
void main() {
  float square = dot(inside, inside);
  if (square > 1.0) discard;
  float toward = sqrt(1.0 - square);
  vec3 body = texture(colors, vec2(color, 0.5)).rgb;
  float width = fwidth(inside.x);
  if (rim.w > 0.5) {
    float line = smoothstep(1.0 - 2.2 * width, 1.0 - 1.2 * width, sqrt(square)) * step(width, 0.2) * edge;
    painted = vec4(mix(body, rim.rgb, line), 1.0);
  } else {
    float light = 0.45 + 0.55 * max(dot(vec3(inside, toward), vec3(-0.35, 0.55, 0.76)), 0.0);
    painted = vec4(body * light, 1.0);
    gl_FragDepth = gl_FragCoord.z + depth_slope * toward;
  }
  float ring = 1.0 - clamp(4.0 * width, 0.06, 0.5);
  if (abs(index - chosen) < 0.5 && sqrt(square) > ring) painted.rgb = vec3(1.0, 0.15, 0.55);
  if (rim.w > 0.5) {
    painted.a = 1.0 - smoothstep(1.0 - width, 1.0, sqrt(square));
    gl_FragDepth = gl_FragCoord.z;
  }
}`;

export interface Look {
  part: number; // of the way from the frame before
  ink: [number, number, number];
  flat: boolean;
  rims: boolean;
  chosen: number;
}

export class Particles {
  private readonly program: Program;
  private readonly table: Table;
  readonly colors: Colors;

  constructor(gl: GL) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.table = new Table(gl, 2);
    this.colors = new Colors(gl);
  }

  /** Places now and before, three coordinates each; where each color stands in the row of them, from 0 to 1. */
  fill(place: Float32Array, before: Float32Array, radius: Float32Array, shade: Float32Array): void {
    const rows = this.table.rows(radius.length);
    for (let one = 0, x = 0, at = 0; one < radius.length; one++, x += 3, at += 8) {
      [rows[at], rows[at + 1], rows[at + 2], rows[at + 3]] = [place[x], place[x + 1], place[x + 2], radius[one]];
      [rows[at + 4], rows[at + 5], rows[at + 6], rows[at + 7]] = [before[x], before[x + 1], before[x + 2], shade[one]];
    }
    this.table.send();
  }

  draw(eye: Eye, look: Look): void {
    const { program } = this;
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("right", ...eye.right);
    program.numbers("up", ...eye.up);
    program.numbers("toward", ...eye.toward);
    program.numbers("part", look.part);
    program.numbers("rim", ...look.ink, look.flat ? 1 : 0);
    program.numbers("edge", look.rims ? 1 : 0);
    program.numbers("chosen", look.chosen);
    this.colors.bind(0);
    program.unit("colors", 0);
    this.table.draw(program, 1);
  }
}
