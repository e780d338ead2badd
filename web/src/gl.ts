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

  attribute(name: string): number {
    return this.gl.getAttribLocation(this.program, name);
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

  unit(name: string, value: number): void {
    this.gl.uniform1i(this.uniform(name), value);
  }
}

/** Numbers on the graphics card, one row for each thing that is drawn. */
export class Rows {
  private readonly buffer: WebGLBuffer;
  private room = 0;
  private held: Float32Array | null = null;

  constructor(private readonly gl: GL) {
    this.buffer = gl.createBuffer()!;
  }

  /** What is there already, the same array, is not sent again: whoever changes one sends another. */
  fill(values: Float32Array): void {
    if (values === this.held) return;
    this.held = values;
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    if (values.byteLength > this.room) {
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
      this.room = values.byteLength;
    } else {
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
    }
  }

  /** Let an attribute read `width` numbers a row from the `from`-th on; rows are `stride` numbers long. */
  feed(attribute: number, width: number, stride = width, from = 0, each = 1): void {
    if (attribute < 0) return;
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.enableVertexAttribArray(attribute);
    gl.vertexAttribPointer(attribute, width, gl.FLOAT, false, 4 * stride, 4 * from);
    gl.vertexAttribDivisor(attribute, each);
  }
}

/** The corners of a square from -1 to 1, as a strip. */
export function square(gl: GL): Rows {
  const rows = new Rows(gl);
  rows.fill(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]));
  return rows;
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
