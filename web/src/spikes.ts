// Limits of a curve's axis that a few outliers would otherwise compress: the rule of `ecume.show.spikes`.

const FEWEST = 20;
const PART = 0.02;
const FENCE = 1;
const ROOM = 0.06;

/** The least and the largest value without outliers, and some room around. */
export function limits(values: number[]): [number, number] {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  let [least, most] = [sorted[0] ?? 0, sorted.at(-1) ?? 1];
  if (values.length >= FEWEST && sorted.length >= FEWEST) {
    const few = Math.max(2, Math.round(PART * sorted.length));
    const [low, high] = [sorted[few]!, sorted[sorted.length - 1 - few]!];
    const fence = FENCE * (high - low);
    if (fence > 0) {
      const kept = sorted.filter((value) => value >= low - fence && value <= high + fence);
      [least, most] = [kept[0]!, kept.at(-1)!];
    }
  }
  const room = most > least ? ROOM * (most - least) : Math.max(Math.abs(most), 1e-12);
  return [least - room, most + room];
}
