// A ruler between two floats, and their distance over time.

import type { Now } from "./asking";
import { millimeters, shade } from "./dish";
import { apart, nearest } from "./rafts";
import { element } from "./toy";

const WHILE = 30; // s
const MOST = 1500; // points

export class Ruler {
  private pair: [number, number] | null = null;
  private first = -1; // end that was chosen, while the other is not
  private history: [time: number, distance: number][] = [];
  private readonly box = element<HTMLInputElement>("ruler");
  private readonly plot = element<HTMLCanvasElement>("plot");

  constructor() {
    this.box.addEventListener("change", () => this.forget());
  }

  /** Choose an end: the second one completes the ruler. What is to be said. */
  choose(one: number): string {
    if (this.first < 0 || this.first === one) {
      this.forget();
      this.first = one;
      return "Now choose the other float.";
    }
    const pair: [number, number] = [this.first, one];
    this.forget();
    [this.pair, this.box.checked] = [pair, true];
    return "";
  }

  /** Floats have other numbers now. */
  forget(): void {
    [this.pair, this.first, this.history] = [null, -1, []];
  }

  /** The two floats that are measured now, if any; the nearest two that are apart unless others were chosen. */
  ends(seen: Now): [number, number] | null {
    if (!this.box.checked) return null;
    const there = this.pair && Math.max(...this.pair) < seen.x.length;
    if (!there) [this.pair, this.history] = [nearest(seen, true) ?? nearest(seen), []];
    return this.pair;
  }

  get chosen(): number {
    return this.first;
  }

  /** Draw the distance of the two over the last while. */
  draw(seen: Now, pair: [number, number] | null): void {
    const { plot } = this;
    const on = plot.getContext("2d")!;
    on.clearRect(0, 0, plot.width, plot.height);
    on.font = "22px system-ui";
    on.fillStyle = shade("muted");
    if (!pair) {
      on.fillText("switch the ruler on, or measure", 12, 36);
      return;
    }
    const past = this.history[this.history.length - 1]?.[0] ?? -1;
    if (past > seen.time) this.history = [];
    if (past !== seen.time) this.history.push([seen.time, apart(seen, ...pair)]);
    this.history = this.history.filter(([time]) => time > seen.time - WHILE).slice(-MOST);
    const [, now] = this.history[this.history.length - 1];
    const most = 1.15 * Math.max(...this.history.map(([, distance]) => distance));
    const [low, tall] = [plot.height - 28, plot.height - 64];
    on.fillText(`l = ${millimeters(now)}`, 12, 24);
    on.fillText(`−${WHILE} s`, 4, plot.height - 6);
    on.fillText("now", plot.width - 48, plot.height - 6);
    on.strokeStyle = shade("line");
    on.lineWidth = 2;
    on.strokeRect(1, low - tall, plot.width - 2, tall);
    const touching = low - (tall * (seen.radius[pair[0]] + seen.radius[pair[1]])) / most;
    on.setLineDash([6, 6]);
    on.beginPath();
    on.moveTo(0, touching);
    on.lineTo(plot.width, touching);
    on.stroke();
    on.setLineDash([]);
    on.strokeStyle = shade("accent");
    on.lineWidth = 3;
    on.beginPath();
    for (const [time, distance] of this.history) on.lineTo(plot.width * (1 - (seen.time - time) / WHILE), low - (tall * distance) / most);
    on.stroke();
    plot.setAttribute("aria-label", `distance of the two floats of the ruler over the last ${WHILE} s, now ${millimeters(now)}`);
  }
}
