// The region of a liquid on the graphics card: colored inside, with a line along its surface.

import type { Eye } from "./camera";
import { type Colors, CORNERS, type GL, Program } from "./gl";
import type { Region } from "./liquid";

const VERTEX = `${CORNERS}
uniform mat4 matrix;
uniform vec4 view;
out vec2 at;
void main() {
  at = 0.5 + 0.5 * corner_of();
  gl_Position = matrix * vec4(mix(view.xz, view.yw, at), 0.0, 1.0);
}`;

const FRAGMENT = `
uniform sampler2D region, colors;
uniform vec3 line;
in vec2 at;
out vec4 painted;
void main() {
  vec2 here = texture(region, at).rg;
  float pixel = max(fwidth(here.r), 1e-6);
  float inside = (here.r - 0.5) / pixel;
  if (inside < -1.0) discard;
  vec3 body = texture(colors, vec2(here.g, 0.5)).rgb;
  float edge = pixel > 0.004 ? 1.0 - smoothstep(0.7, 1.9, abs(inside)) : 0.0;
  painted = vec4(mix(body, line, 0.8 * edge), clamp(inside + 0.7, 0.0, 1.0));
}`;

export class Surface {
  private readonly program: Program;
  private readonly state: WebGLVertexArrayObject;
  private readonly texture: WebGLTexture;
  private region: Region | null = null;

  constructor(private readonly gl: GL) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.state = gl.createVertexArray()!;
    this.texture = gl.createTexture()!;
  }

  fill(region: Region): void {
    const { gl } = this;
    this.region = region;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG16F, region.counts[0], region.counts[1], 0, gl.RG, gl.FLOAT, region.cells);
    for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, way, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
  }

  draw(eye: Eye, colors: Colors, line: [number, number, number]): void {
    const { gl, program, region } = this;
    if (!region) return;
    gl.bindVertexArray(this.state);
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("view", region.low[0], region.high[0], region.low[1], region.high[1]);
    program.numbers("line", ...line);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    program.unit("region", 0);
    colors.bind(1);
    program.unit("colors", 1);
    gl.drawArrays(gl.TRIANGLES, 0, 6);
  }
}
