// The liquid's surface from above, colored by its height.

import type { Eye } from "./camera";
import { Colors, CORNERS, type GL, Program } from "./gl";
import type { Sheet } from "./run";

const VERTEX = `${CORNERS}
uniform mat4 matrix;
uniform vec4 view;
out vec2 at, place;
void main() {
  at = 0.5 + 0.5 * corner_of();
  place = mix(view.xz, view.yw, at);
  gl_Position = matrix * vec4(place, 0.0, 1.0);
}`;

const MOST_WALLS = 32;

const FRAGMENT = `
uniform sampler2D heights, colors;
uniform float round_;
uniform int count;
uniform vec3 walls[${MOST_WALLS}];
in vec2 at, place;
out vec4 painted;
void main() {
  if (round_ > 0.0 && dot(place, place) > round_ * round_) discard;
  for (int k = 0; k < count; k++) if (dot(walls[k].xy, place) < walls[k].z) discard;
  painted = vec4(texture(colors, vec2(texture(heights, at).r, 0.5)).rgb, 1.0);
}`;

export class Heights {
  private readonly program: Program;
  private readonly state: WebGLVertexArrayObject;
  private readonly texture: WebGLTexture;
  readonly colors: Colors;

  constructor(
    private readonly gl: GL,
    private readonly sheet: Sheet,
  ) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.state = gl.createVertexArray()!;
    this.texture = gl.createTexture()!;
    this.colors = new Colors(gl);
  }

  /** Heights as parts of the scale, from 0 to 1, row after row from below. */
  fill(values: Float32Array): void {
    const { gl, sheet } = this;
    const bytes = Uint8Array.from(values, (value) => Math.round(255 * Math.min(Math.max(value, 0), 1)));
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, sheet.columns, sheet.rows, 0, gl.RED, gl.UNSIGNED_BYTE, bytes);
    for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, way, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
  }

  draw(eye: Eye): void {
    const { gl, program } = this;
    gl.bindVertexArray(this.state);
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("view", ...this.sheet.view);
    program.numbers("round_", this.sheet.round);
    const walls = this.sheet.walls.slice(0, MOST_WALLS);
    program.unit("count", walls.length);
    if (walls.length) program.triples("walls", walls.flat());
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    program.unit("heights", 0);
    this.colors.bind(1);
    program.unit("colors", 1);
    gl.drawArrays(gl.TRIANGLES, 0, 6);
  }
}
