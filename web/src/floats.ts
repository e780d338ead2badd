// The compiled bowl: its steps, its neighbor lists, and the swing of its liquid.

import { Memory, type Compiled, type Slot } from "./memory";

export interface CompiledBowl extends Compiled {
  advance(block: number): number;
  renew(block: number): number;
  swing(block: number): number;
}

const OUTDATED = -1;
const CROWDED = 1;
const DIVERGED = 2;

/** The memory of a bowl with so many floats. */
export class Floats extends Memory {
  constructor(
    private readonly compiled: CompiledBowl,
    slots: Slot[],
    floats: number,
  ) {
    super(compiled, slots, floats);
  }

  get steps(): number {
    return this.whole("state.step");
  }

  /** Take so many steps: 0 if all went well, otherwise the status of `ecume.models.model`. */
  advance(steps: number): number {
    const end = this.steps + steps;
    for (;;) {
      this.put("steps", [end - this.steps]);
      if (!this.call(this.compiled.advance)) return DIVERGED;
      const status = this.answered;
      if (status !== OUTDATED) return status;
      if (!this.call(this.compiled.renew)) return DIVERGED;
      if (!this.well) return CROWDED;
    }
  }

  /** Make the neighbor lists at the present positions. */
  renew(): boolean {
    return this.call(this.compiled.renew) && this.well;
  }

  /** The slope of the liquid along an axis and its rate, a while later: `swung_along` of `ecume.show.play.bowl`. */
  swing(slope: number, rate: number, aim: number, omega: number, seconds: number): [number, number] {
    const at = this.of(this.compiled.swing, [slope, rate, aim, omega, seconds]);
    return [this.fresh().getFloat64(at, true), this.fresh().getFloat64(at + 8, true)];
  }
}
