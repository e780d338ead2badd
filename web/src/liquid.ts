// A liquid as a continuous region in 2D and 3D: the sum of smooth kernels around its particles on a grid, and its level of one half.

export interface Tank {
  spacing: number; // m
  low: number[]; // of the tank (m); at open sides, of the view
  high: number[];
  periodic: boolean[];
}

/** The sum of kernels, 1 inside the liquid and 0 outside, and the mean shade of the particles, cell by cell. */
export interface Region {
  counts: number[]; // cells along each axis; cells along x are adjacent in memory
  low: number[];
  high: number[];
  cells: Float32Array; // two numbers each: the sum, and the shade
}

const SMOOTHING = Math.SQRT1_2; // of the kernel: its standard deviation in spacings
const SUPPORT = 4; // of the kernel, in standard deviations
const FINE = 2; // cells per spacing
const MOST_CELLS = 300_000;
const LONELY = 0.36; // the sum at a particle below which it is drawn as a full ball,
const TOGETHER = 0.5; // and above which not at all

/** How steep the sum is at a flat edge, per spacing. */
export const SLOPE = 1 / (SMOOTHING * Math.sqrt(2 * Math.PI));

/** Particles of equal volume with three coordinates each, and the shade of each; `chosen` says which are liquid. */
export function regionOf(tank: Tank, place: Float32Array, shade: Float32Array, chosen: (one: number) => boolean): Region {
  const all = Array.from(shade.keys()).filter(chosen);
  const { counts, low, high, cell, ends } = gridOf(tank, place, all);
  const d = counts.length;
  const total = counts.reduce((product, count) => product * count, 1);
  const [sum, shades] = [new Float32Array(total), new Float32Array(total)];
  const share = tank.spacing ** d / cell.reduce((product, size) => product * size, 1);
  const inside = all.filter((one) => low.every((value, k) => place[3 * one + k] >= value && place[3 * one + k] <= high[k]));
  const at = (one: number, k: number): number => (place[3 * one + k] - low[k]) / cell[k] - 0.5;
  for (const one of inside) {
    for (let corner = 0; corner < 1 << d; corner++) {
      const [to, weight] = cellAt(one, corner);
      sum[to] += share * weight;
      shades[to] += share * weight * shade[one];
    }
  }
  for (const field of [sum, shades]) {
    for (let k = 0; k < d; k++) smooth(field, counts, k, kernel((SMOOTHING * tank.spacing) / cell[k]), ends[k]);
  }
  const cells = new Float32Array(2 * total);
  for (let to = 0; to < total; to++) {
    cells[2 * to] = sum[to];
    cells[2 * to + 1] = sum[to] > 1e-6 ? shades[to] / sum[to] : 0;
  }
  for (const one of inside) {
    let filled = 0;
    for (let corner = 0; corner < 1 << d; corner++) {
      const [from, weight] = cellAt(one, corner);
      filled += weight * sum[from];
    }
    if (filled < TOGETHER) addBall(one, Math.min((TOGETHER - filled) / (TOGETHER - LONELY), 1));
  }
  return { counts, low, high, cells };

  /** One of the cells around a particle, and its weight. */
  function cellAt(one: number, corner: number): [number, number] {
    let [to, weight, stride] = [0, 1, 1];
    for (let k = 0; k < d; k++) {
      const [value, up] = [at(one, k), (corner >> k) & 1];
      const first = Math.floor(value);
      weight *= up ? value - first : 1 - value + first;
      to += stride * folded(first + up, counts[k], ends[k]);
      stride *= counts[k];
    }
    return [to, weight];
  }

  /** Raise the sum to that of a disc or a ball of a part of the particle's size. */
  function addBall(one: number, part: number): void {
    const radius = part * tank.spacing * (d === 2 ? Math.sqrt(1 / Math.PI) : Math.cbrt(0.75 / Math.PI));
    const reach = cell.map((size) => Math.ceil(radius / size + 1));
    const middle = cell.map((_, k) => at(one, k));
    const window = reach.reduce((product, n) => product * (2 * n + 1), 1);
    for (let number = 0; number < window; number++) {
      let [to, stride, rest, square] = [0, 1, number, 0];
      for (let k = 0; k < d; k++) {
        const index = Math.round(middle[k]) - reach[k] + (rest % (2 * reach[k] + 1));
        rest = Math.floor(rest / (2 * reach[k] + 1));
        square += ((index - middle[k]) * cell[k]) ** 2;
        to = index < 0 || index >= counts[k] ? NaN : to + stride * index;
        stride *= counts[k];
      }
      const level = 0.5 + ((radius - Math.sqrt(square)) * SLOPE) / tank.spacing;
      if (to >= 0 && level > cells[2 * to]) cells[2 * to] = level;
    }
  }
}

interface Grid {
  counts: number[];
  low: number[];
  high: number[];
  cell: number[];
  ends: boolean[]; // periodic ones
}

/** In 2D the cells of the tank; in 3D those near the liquid, which stay where they are from frame to frame. */
function gridOf(tank: Tank, place: Float32Array, all: number[]): Grid {
  const size = tank.low.map((value, k) => tank.high[k] - value);
  if (size.length === 2) {
    const cells = divided(size, Math.max(tank.spacing / FINE, Math.sqrt((size[0] * size[1]) / MOST_CELLS)));
    return { ...tank, ...cells, ends: tank.periodic };
  }
  const reach = SUPPORT * SMOOTHING * tank.spacing;
  const [low, high] = [[...tank.low], [...tank.high]];
  for (let k = 0; k < 3; k++) {
    if (tank.periodic[k]) continue;
    let [least, most] = [Infinity, -Infinity];
    for (const one of all) [least, most] = [Math.min(least, place[3 * one + k]), Math.max(most, place[3 * one + k])];
    if (least > most) continue;
    [low[k], high[k]] = [Math.max(low[k], least - reach), Math.min(high[k], most + reach)];
  }
  let fine = tank.spacing / FINE;
  for (;;) {
    const { counts, cell } = divided(size, fine);
    const first = low.map((value, k) => Math.max(Math.floor((value - tank.low[k]) / cell[k]), 0));
    const last = high.map((value, k) => Math.min(Math.ceil((value - tank.low[k]) / cell[k]), counts[k]));
    const taken = first.map((value, k) => Math.max(last[k] - value, 1));
    if (taken.reduce((product, count) => product * count, 1) <= MOST_CELLS) {
      const corner = (index: number[]): number[] => index.map((value, k) => tank.low[k] + value * cell[k]);
      return { counts: taken, low: corner(first), high: corner(first.map((value, k) => value + taken[k])), cell, ends: tank.periodic };
    }
    fine *= Math.SQRT2;
  }
}

function divided(size: number[], fine: number): { counts: number[]; cell: number[] } {
  const counts = size.map((value) => Math.max(2, Math.round(value / fine)));
  return { counts, cell: size.map((value, k) => value / counts[k]) };
}

/** The cell of an index beyond an end: mirrored, or repeated. */
function folded(index: number, count: number, periodic: boolean): number {
  if (index >= 0 && index < count) return index;
  if (periodic) return (index + count) % count;
  return index < 0 ? Math.min(-1 - index, count - 1) : Math.max(2 * count - 1 - index, 0);
}

/** Weights of a Gaussian from its middle on; to share particles linearly has smoothed by a sixth of a cell already. */
function kernel(width: number): Float32Array {
  const variance = Math.max(width * width - 1 / 6, 1e-6);
  const weights = Float32Array.from({ length: Math.ceil(SUPPORT * width) + 1 }, (_, k) => Math.exp((-k * k) / (2 * variance)));
  const total = weights.reduce((sum, weight, k) => sum + (k ? 2 : 1) * weight, 0);
  return weights.map((weight) => weight / total);
}

/** Smooth a field along an axis, in place. */
function smooth(field: Float32Array, counts: number[], axis: number, weights: Float32Array, periodic: boolean): void {
  const reach = weights.length - 1;
  const cells = counts[axis];
  const step = counts.slice(0, axis).reduce((product, count) => product * count, 1);
  const line = new Float32Array(cells + 2 * reach);
  for (let number = 0; number < field.length / cells; number++) {
    const begin = Math.floor(number / step) * step * cells + (number % step);
    let filled = false;
    for (let k = -reach; k < cells + reach; k++) {
      const value = field[begin + step * folded(k, cells, periodic)];
      line[k + reach] = value;
      filled ||= value !== 0;
    }
    if (!filled) continue;
    for (let k = 0; k < cells; k++) {
      let total = weights[0] * line[k + reach];
      for (let m = 1; m <= reach; m++) total += weights[m] * (line[k + reach - m] + line[k + reach + m]);
      field[begin + step * k] = total;
    }
  }
}
