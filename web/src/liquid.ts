// A liquid in 2D as a continuous region: the sum of smooth kernels around its particles on a grid, and its level of one half.

export interface Tank {
  spacing: number; // m
  low: [number, number]; // of the tank (m); at open sides, of the view
  high: [number, number];
  periodic: [boolean, boolean];
}

/** The sum of kernels, 1 inside the liquid and 0 outside, and the mean shade of the particles, cell by cell. */
export interface Region {
  columns: number;
  rows: number;
  low: [number, number];
  high: [number, number];
  cells: Float32Array; // two numbers each: the sum, and the shade
}

const SMOOTHING = Math.SQRT1_2; // of the kernel: its standard deviation in spacings
const SUPPORT = 4; // of the kernel, in standard deviations
const FINE = 2; // cells per spacing
const MOST_CELLS = 300_000;

/** How steep the sum is at a flat edge, per spacing. */
export const SLOPE = 1 / (SMOOTHING * Math.sqrt(2 * Math.PI));

/** Particles of equal volume with three coordinates each, and the shade of each; `chosen` says which are liquid. */
export function regionOf(tank: Tank, place: Float32Array, shade: Float32Array, chosen: (one: number) => boolean): Region {
  const { low, high, spacing, periodic } = tank;
  const [width, height] = [high[0] - low[0], high[1] - low[1]];
  const size = Math.max(spacing / FINE, Math.sqrt((width * height) / MOST_CELLS));
  const [columns, rows] = [Math.max(2, Math.round(width / size)), Math.max(2, Math.round(height / size))];
  const [cellX, cellY] = [width / columns, height / rows];
  const [sum, shades] = [new Float32Array(columns * rows), new Float32Array(columns * rows)];
  const share = spacing ** 2 / (cellX * cellY);
  for (let one = 0; one < shade.length; one++) {
    if (!chosen(one)) continue;
    const [x, y] = [(place[3 * one] - low[0]) / cellX - 0.5, (place[3 * one + 1] - low[1]) / cellY - 0.5];
    if (x < -0.5 || y < -0.5 || x > columns - 0.5 || y > rows - 0.5) continue;
    const [column, row] = [Math.floor(x), Math.floor(y)];
    for (let corner = 0; corner < 4; corner++) {
      const [right, up] = [corner & 1, corner >> 1];
      const weight = share * (right ? x - column : 1 - x + column) * (up ? y - row : 1 - y + row);
      const at = folded(row + up, rows, periodic[1]) * columns + folded(column + right, columns, periodic[0]);
      sum[at] += weight;
      shades[at] += weight * shade[one];
    }
  }
  for (const field of [sum, shades]) {
    smooth(field, columns, rows, 1, columns, kernel((SMOOTHING * spacing) / cellX), periodic[0]);
    smooth(field, rows, columns, columns, 1, kernel((SMOOTHING * spacing) / cellY), periodic[1]);
  }
  const cells = new Float32Array(2 * columns * rows);
  for (let at = 0; at < sum.length; at++) {
    cells[2 * at] = sum[at];
    cells[2 * at + 1] = sum[at] > 1e-6 ? shades[at] / sum[at] : 0;
  }
  return { columns, rows, low, high, cells };
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

/** Smooth lines of so many cells, one line beside the other, in place. */
function smooth(field: Float32Array, cells: number, lines: number, step: number, next: number, weights: Float32Array, periodic: boolean): void {
  const reach = weights.length - 1;
  const line = new Float32Array(cells + 2 * reach);
  for (let number = 0; number < lines; number++) {
    const begin = number * next;
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
