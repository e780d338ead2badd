// The arguments of the compiled bowl in its memory: see ecume.show.play.memory.

/** Name, type, sizes as pairs (a, b) for a floats + b, and value. */
export type Slot = [name: string, kind: string, sizes: [number, number][] | null, value: number | string | boolean | number[] | null];

export interface Compiled {
  memory: WebAssembly.Memory;
  __heap_base: WebAssembly.Global;
  memory_from(address: number): void;
  advance(block: number): number;
  renew(block: number): number;
  swing(block: number): number;
}

const RESULT = 64; // bytes of the block before the arguments
const BYTES: Record<string, number> = { float64: 8, int64: 8, uint32: 4 };

/** The memory of a bowl with so many floats. */
export class Memory {
  private readonly places = new Map<string, { at: number; kind: string; count: number }>();
  private readonly block: number;
  private readonly numbers: number; // a block of five numbers
  private view: DataView;

  constructor(
    private readonly compiled: Compiled,
    slots: Slot[],
    floats: number,
  ) {
    const shapes = slots.map(([, , sizes]) => sizes?.map(([each, rest]) => Math.max(0, Math.round(each * floats + rest))) ?? null);
    let top = compiled.__heap_base.value as number;
    const taken = (bytes: number): number => {
      const at = (top + 63) & ~63;
      top = at + bytes;
      return at;
    };
    this.block = taken(RESULT + 8 * slots.reduce((sum, [, , sizes]) => sum + (sizes ? 5 + 2 * sizes.length : 1), 0));
    this.numbers = taken(RESULT + 8 * 5);
    const arrays = slots.map(([, kind], k) => (shapes[k] ? taken(BYTES[kind.split(" ")[0]] * product(shapes[k]!)) : 0));
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
      const strides = shape.map((_, axis) => BYTES[type] * product(shape.slice(axis + 1)));
      for (const number of [0, 0, product(shape), BYTES[type], arrays[k], ...shape, ...strides]) {
        this.view.setBigInt64(at, BigInt(number), true);
        at += 8;
      }
    });
  }

  /** Write numbers to the beginning of an array, or one number. */
  put(name: string, values: ArrayLike<number>): void {
    const { at, kind } = this.places.get(name)!;
    const view = this.fresh();
    for (let k = 0; k < values.length; k++) {
      if (kind === "float64") view.setFloat64(at + 8 * k, Number(values[k]), true);
      else if (kind === "uint32") view.setUint32(at + 4 * k, values[k], true);
      else view.setBigInt64(at + 8 * k, BigInt(values[k]), true);
    }
  }

  /** The numbers of an array of float64, as they lie there. */
  numbersOf(name: string): Float64Array {
    const { at, count } = this.places.get(name)!;
    return new Float64Array(this.compiled.memory.buffer, at, count);
  }

  get steps(): number {
    return Number(this.fresh().getBigInt64(this.places.get("state.step")!.at, true));
  }

  /** Take so many steps: 0 if all went well, otherwise the status of `ecume.models.model`. */
  advance(steps: number): number {
    const end = this.steps + steps;
    for (;;) {
      this.put("steps", [end - this.steps]);
      if (this.compiled.advance(this.block) !== 0) return DIVERGED;
      const status = Number(this.fresh().getBigInt64(this.block, true));
      if (status !== OUTDATED) return status;
      if (this.compiled.renew(this.block) !== 0) return DIVERGED;
      if (this.fresh().getUint8(this.block) === 0) return CROWDED;
    }
  }

  /** Make the neighbor lists at the present positions. */
  renew(): boolean {
    return this.compiled.renew(this.block) === 0 && this.fresh().getUint8(this.block) !== 0;
  }

  /** The slope of the liquid along an axis and its rate, a while later: `swung_along` of `ecume.show.play.bowl`. */
  swing(slope: number, rate: number, aim: number, omega: number, seconds: number): [number, number] {
    [slope, rate, aim, omega, seconds].forEach((number, k) => this.fresh().setFloat64(this.numbers + RESULT + 8 * k, number, true));
    this.compiled.swing(this.numbers);
    return [this.fresh().getFloat64(this.numbers, true), this.fresh().getFloat64(this.numbers + 8, true)];
  }

  private fresh(): DataView {
    if (this.view.buffer !== this.compiled.memory.buffer) this.view = new DataView(this.compiled.memory.buffer);
    return this.view;
  }
}

const OUTDATED = -1;
export const CROWDED = 1;
export const DIVERGED = 2;

function product(sizes: number[]): number {
  return sizes.reduce((one, other) => one * other, 1);
}
