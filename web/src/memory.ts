// The arguments of a compiled function in its memory: see ecume.show.play.memory.

/** Name, type, sizes as pairs (a, b) for a floats + b, and value; of an array in the memory of a larger one its name. */
export type Slot = [name: string, kind: string, sizes: [number, number][] | null, value: number | string | boolean | (number | string)[] | null];

export type Numbers = Float32Array | Float64Array;

export interface Compiled {
  memory: WebAssembly.Memory;
  __heap_base: WebAssembly.Global;
  memory_from(address: number): void;
}

const RESULT = 64; // bytes of the block before the arguments
const BYTES: Record<string, number> = { float64: 8, int64: 8, record: 4, uint32: 4, int32: 4, float32: 4 };

/** The memory of arguments, in a bowl for so many floats. */
export class Memory {
  private readonly places = new Map<string, { at: number; kind: string; count: number }>();
  private readonly block: number;
  private readonly numbers: number; // a block of a few numbers
  private view: DataView;
  private readonly memory: WebAssembly.Memory;

  constructor(
    compiled: Compiled,
    slots: Slot[],
    floats = 0,
  ) {
    this.memory = compiled.memory;
    const shapes = slots.map(([, , sizes]) => sizes?.map(([each, rest]) => Math.max(0, Math.round(each * floats + rest))) ?? null);
    let top = compiled.__heap_base.value as number;
    const taken = (bytes: number): number => {
      const at = (top + 63) & ~63;
      top = at + bytes;
      return at;
    };
    this.block = taken(RESULT + 8 * slots.reduce((sum, [, , sizes]) => sum + (sizes ? 5 + 2 * sizes.length : 1), 0));
    this.numbers = taken(RESULT + 8 * 5);
    const room = (kind: string, shape: number[]): number => taken(BYTES[kind.split(" ")[0]] * product(shape));
    const arrays = slots.map(([, kind, , value], k) => (shapes[k] && typeof value !== "string" ? room(kind, shapes[k]!) : 0));
    const numbered = new Map(slots.map(([name], k) => [name, k]));
    slots.forEach(([, , , value], k) => {
      if (shapes[k] && typeof value === "string") arrays[k] = arrays[numbered.get(value)!];
    });
    const end = taken(1 << 20);
    const lacking = end + (1 << 20) - compiled.memory.buffer.byteLength;
    if (lacking > 0) compiled.memory.grow(Math.ceil(lacking / 65536));
    new Uint8Array(compiled.memory.buffer).fill(0, this.block, end);
    compiled.memory_from(end);
    this.view = new DataView(compiled.memory.buffer);
    let at = this.block + RESULT;
    slots.forEach(([name, kind, , value], k) => {
      const shape = shapes[k];
      if (!shape) {
        this.places.set(name, { at, kind, count: 1 });
        this.put(name, [Number(value)]);
        at += 8;
        return;
      }
      const [type] = kind.split(" ");
      this.places.set(name, { at: arrays[k], kind: type, count: product(shape) });
      if (Array.isArray(value)) this.put(name, value);
      const axes = type === "record" ? shape.slice(0, -1) : shape;
      const bytes = BYTES[type] * (type === "record" ? shape[shape.length - 1] : 1);
      const strides = axes.map((_, axis) => bytes * product(axes.slice(axis + 1)));
      for (const number of [0, 0, product(axes), bytes, arrays[k], ...axes, ...strides]) {
        this.view.setBigInt64(at, BigInt(number), true);
        at += 8;
      }
    });
  }

  /** Write numbers to the beginning of an array, or one number. */
  put(name: string, values: ArrayLike<number | string>): void {
    const { at, kind } = this.places.get(name)!;
    const view = this.fresh();
    for (let k = 0; k < values.length; k++) {
      if (kind === "float64") view.setFloat64(at + 8 * k, Number(values[k]), true);
      else if (kind === "float32") view.setFloat32(at + 4 * k, Number(values[k]), true);
      else if (BYTES[kind] === 4) view.setUint32(at + 4 * k, Number(values[k]), true);
      else view.setBigInt64(at + 8 * k, BigInt(values[k]), true);
    }
  }

  /** The numbers of an array of floating-point numbers, as they lie there. */
  numbersOf(name: string): Numbers {
    const { at, kind, count } = this.places.get(name)!;
    return new (kind === "float32" ? Float32Array : Float64Array)(this.memory.buffer, at, count);
  }

  /** How many numbers an array has. */
  protected countOf(name: string): number {
    return this.places.get(name)!.count;
  }

  /** The numbers of an array of int64. */
  protected wholes(name: string): number[] {
    const { at, count } = this.places.get(name)!;
    return Array.from(new BigInt64Array(this.memory.buffer, at, count), Number);
  }

  /** Call an entry with at most RESULT / 8 numbers; where its result is. */
  protected of(entry: (block: number) => number, numbers: number[]): number {
    numbers.forEach((number, k) => this.fresh().setFloat64(this.numbers + RESULT + 8 * k, number, true));
    entry(this.numbers);
    return this.numbers;
  }

  /** Call an entry with the arguments: whether all went well. */
  protected call(entry: (block: number) => number): boolean {
    return entry(this.block) === 0;
  }

  /** A whole number among the arguments. */
  protected whole(name: string): number {
    return Number(this.fresh().getBigInt64(this.places.get(name)!.at, true));
  }

  /** Whether the last result is true. */
  protected get well(): boolean {
    return this.fresh().getUint8(this.block) !== 0;
  }

  /** The first number of the last result. */
  protected get answered(): number {
    return Number(this.fresh().getBigInt64(this.block, true));
  }

  protected fresh(): DataView {
    if (this.view.buffer !== this.memory.buffer) this.view = new DataView(this.memory.buffer);
    return this.view;
  }
}

function product(sizes: number[]): number {
  return sizes.reduce((one, other) => one * other, 1);
}
