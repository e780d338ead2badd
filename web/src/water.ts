// A liquid in 3D on the graphics card: a ray per pixel through the kernel sum, translucent, or in the colors of a quantity.

import type { Eye } from "./camera";
import { type Colors, CORNERS, type GL, Program } from "./gl";
import type { Region } from "./liquid";

const CLEAR = 0.35; // how far light goes until 1/e of it is left, in parts of the tank's smallest side

const VERTEX = `${CORNERS}
out vec2 at;
void main() {
  at = corner_of();
  gl_Position = vec4(at, 0.0, 1.0);
}`;

// The shading is that of movies (show/sph/water.py).
const FRAGMENT = `
uniform highp sampler3D region;
uniform sampler2D colors;
uniform vec3 low, high, cell, eye, right, up, toward, ground;
uniform vec2 slope;
uniform mat4 matrix;
uniform float clear, opaque;
in vec2 at;
out vec4 painted;
const vec3 SUN = normalize(vec3(-0.35, 0.80, 0.49));
const vec3 HALF = normalize(SUN + vec3(0.0, 0.0, 1.0));
const vec3 SKY = vec3(0.93, 0.97, 1.0);
vec2 field(vec3 place) { return texture(region, (place - low) / (high - low)).rg; }
float level(vec3 place) { return field(place).r - 0.5; }
void main() {
  vec3 way = normalize(right * at.x * slope.x + up * at.y * slope.y - toward);
  vec3 one = (low - eye) / way, other = (high - eye) / way;
  vec3 enter = min(one, other), leave = max(one, other);
  float first = max(max(enter.x, enter.y), max(enter.z, 0.0)), last = min(min(leave.x, leave.y), leave.z);
  if (first >= last) discard;
  float stride = 0.6 * min(min(cell.x, cell.y), cell.z);
  float hit = -1.0, deep = 0.0, before = level(eye + first * way);
  bool wall = before > 0.0;
  if (wall) hit = first;
  for (int k = 1; k < 1024; k++) {
    float now = first + float(k) * stride;
    float part = level(eye + min(now, last) * way);
    if (part > 0.0 && before > 0.0) deep += stride;
    else if (part > 0.0) deep += stride * part / (part - before);
    else if (before > 0.0) deep += stride * before / (before - part);
    if (part > 0.0 && hit < 0.0) {
      float outside = now - stride, inside = min(now, last);
      for (int h = 0; h < 5; h++) {
        float middle = 0.5 * (outside + inside);
        if (level(eye + middle * way) > 0.0) inside = middle;
        else outside = middle;
      }
      hit = 0.5 * (outside + inside);
    }
    before = part;
    if (now >= last) break;
    if (opaque > 0.5 && hit >= 0.0) break;
  }
  if (hit < 0.0) discard;
  vec3 place = eye + hit * way;
  vec3 normal;
  if (wall) {
    normal = enter.x >= max(enter.y, enter.z) ? vec3(-sign(way.x), 0.0, 0.0)
      : enter.y >= enter.z ? vec3(0.0, -sign(way.y), 0.0) : vec3(0.0, 0.0, -sign(way.z));
  } else {
    vec3 x = vec3(cell.x, 0.0, 0.0), y = vec3(0.0, cell.y, 0.0), z = vec3(0.0, 0.0, cell.z);
    normal = -normalize(vec3(
      (level(place + x) - level(place - x)) / cell.x,
      (level(place + y) - level(place - y)) / cell.y,
      (level(place + z) - level(place - z)) / cell.z) + vec3(0.0, 1e-12, 0.0));
  }
  vec3 turned = vec3(dot(normal, right), dot(normal, up), dot(normal, toward));
  float facing = clamp(dot(normal, -way), 0.0, 1.0);
  float light = clamp(dot(turned, SUN), 0.0, 1.0);
  float shine = 0.45 * pow(clamp(dot(turned, HALF), 0.0, 1.0), 60.0);
  vec3 body = texture(colors, vec2(field(place).g, 0.5)).rgb;
  if (opaque > 0.5) {
    painted = vec4(clamp(body * (0.5 + 0.5 * light) + 0.4 * shine, 0.0, 1.0), 1.0);
  } else {
    // Before a dark ground water is seen by the light that it scatters, before a bright one by the light that it absorbs.
    float dark = 1.0 - dot(ground, vec3(1.0 / 3.0));
    vec3 passed = mix(0.85, 0.5, dark) * exp(-deep / clear * (1.15 - body));
    float mean = (passed.r + passed.g + passed.b) / 3.0;
    float mirrored = 0.02 + 0.98 * pow(1.0 - facing, 5.0), lit = mix(0.72, 0.5, dark) + mix(0.28, 0.5, dark) * light;
    vec3 own = body * (1.0 - mean) * mix(0.55, 1.15, dark) * lit * (1.0 - mirrored) + SKY * mirrored * mix(1.0, 0.6, dark) + shine;
    // A page blends all colors alike: what is behind is tinted by the mean, and the difference is added.
    float kept = mean * lit * (1.0 - mirrored);
    painted = vec4(clamp(own + (passed - mean) * lit * (1.0 - mirrored) * ground, 0.0, 1.0), 1.0 - kept);
  }
  vec4 clip = matrix * vec4(place, 1.0);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
}`;

export class Water {
  private readonly program: Program;
  private readonly state: WebGLVertexArrayObject;
  private readonly texture: WebGLTexture;
  private region: Region | null = null;

  constructor(
    private readonly gl: GL,
    private readonly smallest: number, // side of the tank (m)
  ) {
    this.program = new Program(gl, VERTEX, FRAGMENT);
    this.state = gl.createVertexArray()!;
    this.texture = gl.createTexture()!;
  }

  fill(region: Region): void {
    const { gl } = this;
    this.region = region;
    const [columns, rows, layers] = region.counts;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RG16F, columns, rows, layers, 0, gl.RG, gl.FLOAT, region.cells);
    for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_3D, way, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(gl.TEXTURE_3D, way, gl.CLAMP_TO_EDGE);
  }

  /** Over a ground of this color. */
  draw(eye: Eye, colors: Colors, ground: [number, number, number], opaque: boolean): void {
    const { gl, program, region } = this;
    if (!region) return;
    gl.bindVertexArray(this.state);
    program.use();
    program.matrix("matrix", eye.matrix);
    program.numbers("low", ...region.low);
    program.numbers("high", ...region.high);
    program.numbers("cell", ...region.counts.map((count, k) => (region.high[k] - region.low[k]) / count));
    program.numbers("eye", ...eye.place);
    program.numbers("right", ...eye.right);
    program.numbers("up", ...eye.up);
    program.numbers("toward", ...eye.toward);
    program.numbers("slope", ...eye.slope);
    program.numbers("ground", ...ground);
    program.numbers("clear", CLEAR * this.smallest);
    program.numbers("opaque", opaque ? 1 : 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, this.texture);
    program.unit("region", 0);
    colors.bind(1);
    program.unit("colors", 1);
    gl.blendFuncSeparate(gl.ONE, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    gl.drawArrays(gl.TRIANGLES, 0, 6);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
  }
}
