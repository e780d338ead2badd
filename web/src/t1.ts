// Four soft spheres that exchange neighbors, simulated in the page: the thickness of their films is seen.

import type { Pulled } from "./asking";
import type { Clusters } from "./cluster";
import { shade } from "./dish";
import { begun, beginning, type Inside } from "./inside";
import { offerLinks } from "./sharing";
import { bytes, element, header, paintBar, slider, themed, Toy } from "./toy";

interface Header {
  title: string;
  speeds: number[];
  colors: [string, string]; // color maps for light and dark pages
}

const [LEAST, MOST] = [-4, 0]; // powers of ten of the thickness that colors show
const SEEN = 1.2; // radii: the thickest film that is drawn
const HALF = 3.05; // radii from the middle to the edge of the picture
const PAIRS = [[0, 1, 2], [2, 3, 3], [0, 2, 4], [0, 3, 4], [1, 2, 4], [1, 3, 4]] as const; // spheres, place of the gap
const DASHES = [[], [8, 6], [2, 4]];
const NAMES: [name: string, tell: (value: number) => string][] = [
  ["first gap", (value) => `${tidy(value)} R`],
  ["reduced force", (value) => `${tidy(value)} ER²`],
  ["inward pull of the sides", (value) => `${tidy(value)} × the others'`],
];

const SMALL = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function power(exponent: number): string {
  return `10${exponent < 0 ? "⁻" : ""}${SMALL[Math.abs(exponent)]}`;
}

function tidy(value: number): string {
  if (value === 0 || Math.abs(value) >= 1e-3) return String(Number(value.toPrecision(3)));
  const [head, exponent] = value.toExponential(2).split("e").map(Number);
  return head === 1 ? power(exponent) : `${head}·${power(exponent)}`;
}

class Cluster extends Toy<Pulled> {
  private readonly canvas = element<HTMLCanvasElement>("canvas");
  private shown = "";
  private ended = "";

  constructor(
    inside: Inside,
    private readonly told: Clusters,
    private readonly top: Header,
  ) {
    super("cluster", top.title, top.speeds, inside);
    element("anew").addEventListener("click", () => void this.act("anew"));
    [element("least").textContent, element("most").textContent] = [power(LEAST), "1"];
    void offerLinks(inside, "cluster", (text) => this.say(text), (fragment) => this.act("bring", { fragment })).then(() => this.follow());
  }

  protected draw(seen: Pulled): void {
    const shown = JSON.stringify(seen.chosen);
    if (shown !== this.shown) this.offer(seen);
    this.shown = shown;
    this.picture(seen);
    this.curves(seen);
  }

  protected tell(seen: Pulled): void {
    const { time, steps, duration, outcome } = seen;
    const ends: Record<string, string> = {
      t1: duration === null ? "neighbors were exchanged, and the cluster was torn" : `neighbors exchanged after ${duration.toPrecision(6)}`,
      blocked: "blocked: the neighbors stay",
      dissociated: "the cluster came apart",
    };
    const end = outcome ? ` · ${ends[outcome]}` : "";
    element("clock").textContent = `t = ${time.toPrecision(3)} ηR²/F · ${steps} steps${end}${this.slow(seen)}`;
    if (end !== this.ended && end) element("heard").textContent = ends[outcome];
    this.ended = end;
  }

  /** Sliders for what is chosen, and the colors of films. */
  private offer({ chosen }: Pulled): void {
    const had = document.activeElement?.getAttribute("aria-label");
    const rows = this.told.choices.map((values, which) => {
      const [name, tell] = NAMES[which];
      const range = { min: 0, max: values.length - 1, step: 1, value: chosen[which] };
      return slider(name, "the cluster", range, (place) => tell(values[place]), (value) => this.act("choose", { which, value }));
    });
    element("sliders").replaceChildren(...rows);
    if (had) element("sliders").querySelector<HTMLElement>(`[aria-label="${CSS.escape(had)}"]`)?.focus();
    paintBar(bytes(themed(this.top.colors)));
  }

  private color(part: number): number[] {
    const map = bytes(themed(this.top.colors));
    const place = 3 * Math.round(255 * Math.min(1, Math.max(0, part)));
    return [...map.subarray(place, place + 3)];
  }

  private picture(seen: Pulled): void {
    const { canvas } = this;
    const ratio = window.devicePixelRatio;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const on = canvas.getContext("2d")!;
    const unit = Math.min(width, height) / 2 / HALF;
    const place = (k: number): [number, number] => [width / 2 + unit * seen.places[2 * k], height / 2 - unit * seen.places[2 * k + 1]];
    on.clearRect(0, 0, width, height);
    for (let k = 0; k < 4; k++) {
      on.beginPath();
      on.arc(...place(k), unit, 0, 2 * Math.PI);
      on.fillStyle = shade("solid");
      on.fill();
      on.lineWidth = ratio;
      on.strokeStyle = shade("rim");
      on.stroke();
    }
    this.films(on, seen, place, unit);
    if (element<HTMLInputElement>("arrows").checked) this.forces(on, seen, place, unit);
    this.thicknesses(on, seen, place, unit);
    const [horizontal, vertical, diagonal] = seen.instant.slice(2, 5).map(tidy);
    canvas.setAttribute("aria-label", `four spheres: the film between left and right is ${horizontal}, between top and bottom ${vertical}, the others ${diagonal} radii thick`);
  }

  /** Films as bars across the gaps, colored by their thickness. */
  private films(on: CanvasRenderingContext2D, seen: Pulled, place: (k: number) => [number, number], unit: number): void {
    on.lineCap = "round";
    for (const [one, other, gap] of PAIRS) {
      const thick = seen.instant[gap];
      if (thick > SEEN) continue;
      const [[ax, ay], [bx, by]] = [place(one), place(other)];
      const [x, y, far] = [(ax + bx) / 2, (ay + by) / 2, Math.hypot(bx - ax, by - ay)];
      const half = 0.5 * unit * Math.sqrt(1 / (1 + 4 * thick));
      const [along, up] = [(half * (by - ay)) / far, (-half * (bx - ax)) / far];
      const [red, green, blue] = this.color((Math.log10(thick) - LEAST) / (MOST - LEAST));
      for (const [style, more] of [[shade("inside"), 4], [`rgb(${red}, ${green}, ${blue})`, 0]] as const) {
        on.strokeStyle = style;
        on.lineWidth = Math.max(0.07 * unit, unit * thick) + more;
        on.beginPath();
        on.moveTo(x - along, y - up);
        on.lineTo(x + along, y + up);
        on.stroke();
      }
    }
  }

  /** The thickness of each film: in the middle of the cluster on a sphere beside it, otherwise outside. */
  private thicknesses(on: CanvasRenderingContext2D, seen: Pulled, place: (k: number) => [number, number], unit: number): void {
    on.font = `${Math.max(11, 0.19 * unit)}px system-ui`;
    [on.textAlign, on.textBaseline] = ["center", "middle"];
    on.lineWidth = 4;
    [on.strokeStyle, on.fillStyle] = [shade("inside"), shade("ink")];
    for (const [one, other, gap] of PAIRS) {
      if (seen.instant[gap] > SEEN) continue;
      const [[ax, ay], [bx, by]] = [place(one), place(other)];
      const [x, y, far] = [(ax + bx) / 2, (ay + by) / 2, Math.hypot(bx - ax, by - ay)];
      const [across, down] = [(unit * (bx - ax)) / far, (unit * (by - ay)) / far];
      const [outward, beside] = [x - on.canvas.width / 2, y - on.canvas.height / 2];
      const central = Math.hypot(outward, beside) < 0.1 * unit;
      const side = outward * down - beside * across < 0 ? -1 : 1;
      const [more, aside] = central ? [0.45, 0.3] : [0, 0.72 * side];
      const [right, low] = [x + more * across + aside * down, y + more * down - aside * across];
      on.strokeText(tidy(seen.instant[gap]), right, low);
      on.fillText(tidy(seen.instant[gap]), right, low);
    }
  }

  /** The pull on each sphere. */
  private forces(on: CanvasRenderingContext2D, { pull, time }: Pulled, place: (k: number) => [number, number], unit: number): void {
    const most = Math.max(...pull.map(Math.abs));
    if (time === 0) return;
    const [across, down] = pull.map((force) => (0.8 * unit * force) / most);
    const all: [number, number][] = [[across, 0], [-across, 0], [0, down], [0, -down]];
    on.strokeStyle = on.fillStyle = shade("arrow");
    on.lineWidth = 0.05 * unit;
    all.forEach(([right, low], k) => {
      const size = Math.hypot(right, low);
      if (size < 0.02 * unit) return;
      const [x, y] = place(k);
      const [tx, ty] = [x + right, y + low];
      on.beginPath();
      on.moveTo(x, y);
      on.lineTo(tx, ty);
      on.stroke();
      const [ux, uy, head] = [right / size, low / size, 0.16 * unit];
      on.beginPath();
      on.moveTo(tx + head * ux, ty + head * uy);
      on.lineTo(tx - head * uy * 0.6, ty + head * ux * 0.6);
      on.lineTo(tx + head * uy * 0.6, ty - head * ux * 0.6);
      on.fill();
    });
  }

  /** The gaps over time, by powers of ten. */
  private curves({ past, instant }: Pulled): void {
    const plot = element<HTMLCanvasElement>("plot");
    const on = plot.getContext("2d")!;
    const rows = [...past.slice(0, -1), [instant[0], ...instant.slice(2, 5)]];
    const [left, low, tall, long] = [56, plot.height - 34, plot.height - 52, plot.width - 66];
    const most = Math.max(rows[rows.length - 1][0], 1e-9);
    const bottom = Math.floor(Math.log10(Math.min(...rows.flatMap(([, ...gaps]) => gaps))));
    const y = (gap: number): number => low - (tall * (Math.log10(gap) - bottom)) / (1 - bottom);
    on.clearRect(0, 0, plot.width, plot.height);
    on.font = "20px system-ui";
    on.textAlign = "left";
    on.lineWidth = 1;
    on.setLineDash([]);
    for (let power = bottom; power <= 0; power++) {
      on.strokeStyle = shade("line");
      on.beginPath();
      on.moveTo(left, y(10 ** power));
      on.lineTo(left + long, y(10 ** power));
      on.stroke();
      on.fillStyle = shade("muted");
      on.fillText(tidy(10 ** power), 2, y(10 ** power) + 6);
    }
    on.fillText("0", left, plot.height - 8);
    on.textAlign = "right";
    on.fillText(`t = ${most.toPrecision(3)}`, left + long, plot.height - 8);
    on.textAlign = "left";
    on.lineWidth = 3;
    on.strokeStyle = shade("accent");
    DASHES.forEach((dash, k) => {
      on.setLineDash(dash);
      on.beginPath();
      for (const row of rows) on.lineTo(left + (long * row[0]) / most, y(row[k + 1]));
      on.stroke();
    });
  }
}

beginning(async () => {
  const [inside, cases] = await begun<Clusters>("cases");
  new Cluster(inside, cases, header<Header>());
});
