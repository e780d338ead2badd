// Numbers as people read them.

const PREFIXES: [number, string][] = [
  [1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"],
]; // prettier-ignore
const SIMPLE = new Set(["m", "s", "N", "J", "Pa", "m/s", "Hz", "W"]);

/** The prefix that shows a number of this size best, where the unit takes one. */
export function prefixed(size: number, unit: string): { factor: number; name: string } {
  if (!SIMPLE.has(unit) || size === 0) return { factor: 1, name: unit === "1" ? "" : unit };
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least * 0.9995) ?? PREFIXES[PREFIXES.length - 1];
  return { factor, name: prefix + unit };
}

/** A number and its unit: 1.2 mm. */
export function told(value: number, unit: string): string {
  if (!Number.isFinite(value)) return "none";
  const { factor, name } = prefixed(Math.abs(value), unit);
  return name ? `${round(value / factor)} ${name}` : round(value / factor);
}

export function round(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}
