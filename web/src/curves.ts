// Named numbers over time, beside the picture; a click goes to that time.

import uPlot from "uplot";
import type { Player } from "./player";
import type { Run } from "./run";
import { limits } from "./spikes";
import { prefixed, round } from "./told";

const MOST = 2; // curves beside one another

function style(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

class Curve {
  private plot: uPlot | null = null;
  private readonly select = document.createElement("select");
  private readonly unit = document.createElement("span");
  private readonly room = document.createElement("div");

  constructor(
    parent: HTMLElement,
    private readonly run: Run,
    private readonly player: Player,
    name: string,
  ) {
    for (const number of run.header.numbers) this.select.append(new Option(number.name.replaceAll("_", " "), number.name));
    this.select.value = name;
    this.select.setAttribute("aria-label", "number that the curve shows");
    this.select.addEventListener("change", () => this.renew());
    this.room.className = "curve";
    this.unit.className = "unit";
    parent.append(this.select, this.unit, this.room);
    this.renew();
  }

  renew(): void {
    this.plot?.destroy();
    const values = this.run.numbers(this.select.value);
    const given = this.run.header.numbers.find((number) => number.name === this.select.value)?.unit ?? "";
    const [low, high] = limits(values);
    const unit = prefixed(Math.max(Math.abs(low), Math.abs(high)), given);
    const axis = { stroke: style("--muted"), grid: { stroke: style("--line"), width: 1 }, ticks: { show: false } };
    const options: uPlot.Options = {
      width: Math.max(this.room.clientWidth, 120),
      height: 130,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false }, y: { range: (): [number, number] => [low / unit.factor, high / unit.factor] } },
      axes: [
        { ...axis, size: 28, font: "11px system-ui" },
        { ...axis, size: 54, font: "11px system-ui", values: (_, splits): string[] => splits.map(round) },
      ],
      series: [{}, { stroke: style("--accent"), width: 1.5, points: { show: false } }],
      hooks: { draw: [(plot): void => this.cursor(plot)], ready: [(plot): void => this.listen(plot)] },
    };
    this.unit.textContent = unit.name;
    this.plot = new uPlot(options, [this.run.times, values.map((value) => value / unit.factor)], this.room);
  }

  resize(): void {
    this.plot?.setSize({ width: Math.max(this.room.clientWidth, 120), height: 130 });
  }

  redraw(): void {
    this.plot?.redraw(false, false);
  }

  private cursor(plot: uPlot): void {
    const time = this.run.times[this.player.frame] ?? 0;
    const x = plot.valToPos(time, "x", true);
    plot.ctx.save();
    plot.ctx.strokeStyle = style("--ink");
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, plot.bbox.top);
    plot.ctx.lineTo(x, plot.bbox.top + plot.bbox.height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  private listen(plot: uPlot): void {
    plot.over.addEventListener("click", (event) => {
      const time = plot.posToVal(event.offsetX, "x");
      const later = this.run.times.findIndex((one) => one >= time);
      this.player.seek(later < 0 ? this.player.end : later);
    });
  }
}

export class Curves {
  private readonly curves: Curve[];

  constructor(parent: HTMLElement, run: Run, player: Player) {
    const names = run.header.shown.slice(0, MOST);
    this.curves = names.map((name) => new Curve(parent, run, player, name));
    let last = -1;
    player.onChange(() => {
      if (player.frame !== last) for (const curve of this.curves) curve.redraw();
      last = player.frame;
    });
    window.addEventListener("resize", () => this.curves.forEach((curve) => curve.resize()));
  }

  /** After new frames, or another light. */
  renew(): void {
    for (const curve of this.curves) curve.renew();
  }
}
