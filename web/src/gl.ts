// The little that all programs of the graphics card share.

export type GL = WebGL2RenderingContext;

export class Program {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();

  constructor(
    readonly gl: GL,
    vertex: string,
    fragment: string,
  ) {
    this.program = gl.createProgram()!;
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${source}`);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "shader");
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(this.program) ?? "program");
    }
  }

  use(): void {
    this.gl.useProgram(this.program);
  }

  private uniform(name: string): WebGLUniformLocation | null {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name)!;
  }

  matrix(name: string, value: Float32Array): void {
    this.gl.uniformMatrix4fv(this.uniform(name), false, value);
  }

  numbers(name: string, ...value: number[]): void {
    const place = this.uniform(name);
    if (value.length === 1) this.gl.uniform1f(place, value[0]);
    else if (value.length === 2) this.gl.uniform2f(place, value[0], value[1]);
    else if (value.length === 3) this.gl.uniform3f(place, value[0], value[1], value[2]);
    else this.gl.uniform4f(place, value[0], value[1], value[2], value[3]);
  }

  triples(name: string, values: number[]): void {
    this.gl.uniform3fv(this.uniform(name), values);
  }

  unit(name: string, value: number): void {
    this.gl.uniform1i(this.uniform(name), value);
  }
}

const WIDE = 1024; // texels in a line of a table

/** A square as two triangles: which of its corners, from -1 to 1, the vertex is. */
export const CORNERS = `
vec2 corner_of() {
  int k = gl_VertexID % 6;
  return vec2(k == 1 || k == 2 || k == 4 ? 1.0 : -1.0, k == 2 || k == 4 || k == 5 ? 1.0 : -1.0);
}`;

/**
 * What a vertex program needs to read its square's row of a table, four numbers at once, and which corner it is: two
 * triangles a row, all in one call. Instances would do, too, but without a graphics card each one is a call of its own.
 */
export const SQUARES = `${CORNERS}
uniform highp sampler2D table;
int square_number() { return gl_VertexID / 6; }
vec4 numbers(int each, int k) {
  int at = each * square_number() + k;
  return texelFetch(table, ivec2(at % ${WIDE}, at / ${WIDE}), 0);
}`;

/** Rows of numbers on the graphics card, so many times four for each square that is drawn. */
export class Table {
  private readonly texture: WebGLTexture;
  private readonly nothing: WebGLVertexArrayObject;
  private room = new Float32Array(0);
  private lines = 0;
  private count = 0;

  constructor(
    private readonly gl: GL,
    private readonly each: number,
  ) {
    this.texture = gl.createTexture()!;
    this.nothing = gl.createVertexArray()!;
  }

  /** Room for so many rows, to be written into, and then sent. */
  rows(count: number): Float32Array {
    this.count = count;
    const lines = Math.max(1, Math.ceil((count * this.each) / WIDE));
    if (lines > this.room.length / (4 * WIDE)) this.room = new Float32Array(4 * WIDE * lines);
    return this.room;
  }

  send(): void {
    const { gl, room } = this;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    const lines = room.length / (4 * WIDE);
    const used = Math.max(1, Math.ceil((this.count * this.each) / WIDE));
    if (lines !== this.lines) {
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, WIDE, lines, 0, gl.RGBA, gl.FLOAT, room);
      for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, way, gl.NEAREST);
      this.lines = lines;
    } else {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, WIDE, used, gl.RGBA, gl.FLOAT, room);
    }
  }

  draw(program: Program, unit: number): void {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    program.unit("table", unit);
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * this.count);
  }
}

/** A row of colors. */
export class Colors {
  private readonly texture: WebGLTexture;

  constructor(private readonly gl: GL) {
    this.texture = gl.createTexture()!;
  }

  fill(rgb: Uint8Array, sharp: boolean): void {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, rgb.length / 3, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, rgb);
    const how = sharp ? gl.NEAREST : gl.LINEAR;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, how);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, how);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  }

  bind(unit: number): void {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
  }
}
