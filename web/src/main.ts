// The page: puts the parts together and listens to mouse, fingers and keys.

import { Camera } from "./camera";
import { Curves } from "./curves";
import { element, fill, inspect } from "./panels";
import { Player } from "./player";
import type { Run } from "./run";
import { axes, colorBar, lengthBar, scale } from "./scalebar";
import { colorsOf, embedded, Server } from "./source";
import { type Choice, SPECIES, Stage } from "./stage";
import { round, told } from "./told";

const SPEEDS = [1 / 8, 1 / 4, 1 / 2, 1, 2, 4, 8];
const SLOW = 40; // ms from picture to picture
const PATIENCE = 8; // so many slow ones in a row are too many
const ASK_EVERY = 1000; // ms, for news of a run in progress

class Page {
  private readonly player: Player;
  private readonly stage: Stage;
  private readonly camera: Camera;
  private readonly curves: Curves;
  private readonly choice: Choice = { coloring: SPECIES, range: [0, 1], chosen: -1, links: true, particles: false };
  private follow = false;
  private dirty = true;
  private slow = 0; // pictures in a row that came late
  private last = 0; // when the last one came (ms)
  drawn = 0; // pictures so far

  constructor(
    private readonly run: Run,
    private readonly canvas: HTMLCanvasElement,
  ) {
    const { header } = run;
    this.player = new Player(() => run.frames);
    this.camera = new Camera(header.dimension, header.low, header.high, header.up);
    this.stage = new Stage(canvas, run, this.camera);
    fill(run);
    this.lights();
    this.curves = new Curves(element("curves"), run, this.player);
    this.bars();
    this.color(header.usual);
    this.controls();
    this.pointing();
    this.keys();
    this.player.onChange(() => this.refresh());
    this.refresh();
    requestAnimationFrame((now) => this.tick(now));
    if (header.live) this.live();
  }

  private tick(now: number): void {
    this.player.tick(now);
    this.pace(now);
    if (this.stage.resize()) this.dirty = true;
    if (this.dirty && this.run.frames) this.draw();
    requestAnimationFrame((later) => this.tick(later));
  }

  /** While it plays and pictures come slowly, they are drawn with fewer pixels; one that stands still has all of them. */
  private pace(now: number): void {
    const { playing } = this.player;
    this.slow = playing && now - this.last > SLOW ? this.slow + 1 : 0;
    this.last = now;
    if (!playing || this.slow >= PATIENCE) {
      this.stage.hurry(playing);
      this.slow = 0;
    }
  }

  private draw(): void {
    this.dirty = false;
    if (this.follow && this.choice.chosen >= 0 && this.stage.shown) {
      const d = this.run.header.dimension;
      const place = this.run.instant(this.player.frame).position;
      this.camera.follow(place.subarray(d * this.choice.chosen, d * this.choice.chosen + d));
    }
    this.stage.draw(this.player.frame, this.player.part, this.choice);
    const pixels = this.canvas.clientHeight;
    const meters = this.stage.eye.pixel * this.canvas.height * (this.canvas.clientWidth / pixels);
    lengthBar(element("scale-bar"), element("scale-text"), meters, this.canvas.clientWidth);
    if (this.run.header.dimension === 3) axes(element("axes"), this.stage.eye);
    this.drawn += 1;
    document.body.dataset.drawn = String(this.drawn);
  }

  /** Let the page say what the player does. */
  private refresh(): void {
    const slider = element("time") as HTMLInputElement;
    slider.max = String(this.player.end);
    slider.value = String(this.player.frame);
    const time = `${told(this.run.times[this.player.frame] ?? 0, "s")}`;
    slider.setAttribute("aria-valuetext", time);
    element("clock").textContent = time;
    const play = element("play");
    play.textContent = this.player.playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", this.player.playing ? "pause" : "play");
    (element("speed") as HTMLSelectElement).value = String(this.player.speed);
    if (this.run.frames) inspect(this.run, this.run.instant(this.player.frame), this.choice.chosen);
    this.dirty = true;
  }

  private color(name: string): void {
    this.choice.coloring = name;
    (element("coloring") as HTMLSelectElement).value = name;
    const coloring = this.stage.coloring(name);
    element("bar").hidden = !coloring;
    const scaled = coloring ? (this.run.header.apart ?? Infinity) : 0; // the species before this one have a scale's colors
    [...element("kinds").children].forEach((one, kind) => ((one as HTMLElement).hidden = kind < scaled));
    if (coloring) {
      const [low, high] = this.run.range(`array/${name}`);
      this.choice.range = high > low ? [low, high] : [low - 0.5, low + 0.5];
      const colors = colorsOf(this.run.header, coloring.map);
      const label = name.replaceAll("_", " ");
      colorBar(element("bar"), scale(colors, label, coloring.unit, this.choice.range));
    }
    this.stage.stale();
    this.dirty = true;
  }

  private bars(): void {
    element("links-label").hidden = !this.run.header.linked;
    element("particles-label").hidden = !this.run.header.liquid;
    this.legends();
    const select = element("coloring") as HTMLSelectElement;
    select.append(new Option(SPECIES, SPECIES));
    for (const { name } of this.run.header.colorings) select.append(new Option(name.replaceAll("_", " "), name));
    select.addEventListener("change", () => this.color(select.value));
  }

  /** The bars of colors that do not change with the chosen quantity. */
  private legends(): void {
    const { sheet, linked } = this.run.header;
    if (sheet) colorBar(element("sheet-bar"), { ...sheet, rgb: colorsOf(this.run.header, sheet.map) });
    if (linked) {
      const colors = colorsOf(this.run.header, "viridis");
      colorBar(element("film-bar"), scale(colors, "gap of the film", "m", this.stage.gaps, true));
    }
  }

  private controls(): void {
    const speed = element("speed") as HTMLSelectElement;
    for (const value of SPEEDS) speed.append(new Option(value < 1 ? `1/${round(1 / value)}` : String(value), String(value)));
    speed.addEventListener("change", () => this.player.faster(Number(speed.value) / this.player.speed));
    element("play").addEventListener("click", () => this.player.toggle());
    const slider = element("time") as HTMLInputElement;
    slider.addEventListener("input", () => {
      this.player.playing = false;
      this.player.seek(Number(slider.value));
    });
    element("links").addEventListener("change", (event) => {
      this.choice.links = (event.target as HTMLInputElement).checked;
      this.dirty = true;
    });
    element("particles").addEventListener("change", (event) => {
      this.choice.particles = (event.target as HTMLInputElement).checked;
      this.dirty = true;
    });
    element("light").addEventListener("click", () => this.otherLight());
  }

  private lights(): void {
    const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.light = dark ? "dark" : "light";
  }

  private otherLight(): void {
    const { dataset } = document.documentElement;
    dataset.light = dataset.light === "dark" ? "light" : "dark";
    this.curves.renew();
    this.legends();
    this.color(this.choice.coloring);
  }

  /** A place of the page as one of the canvas, from -1 to 1. */
  private on(event: { clientX: number; clientY: number }): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    return [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
  }

  private choose(event: PointerEvent): void {
    this.choice.chosen = this.stage.at(...this.on(event));
    this.refresh();
  }

  private pointing(): void {
    const { canvas } = this;
    const fingers = new Map<number, PointerEvent>();
    let gone = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      gone = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
      gone += Math.hypot(dx, dy);
      const other = [...fingers.values()].find((one) => one.pointerId !== event.pointerId);
      if (other) this.pinch(before, event, other);
      else {
        const ratio = canvas.height / canvas.clientHeight;
        this.camera.drag(dx * ratio, dy * ratio, !event.shiftKey && event.buttons !== 2, canvas.height);
      }
      fingers.set(event.pointerId, event);
      this.dirty = true;
    });
    const up = (event: PointerEvent): void => {
      if (fingers.delete(event.pointerId) && gone < 5 && event.type === "pointerup") this.choose(event);
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      this.camera.closer(Math.exp(-event.deltaY / 600), ...this.on(event), this.stage.aspect);
      this.dirty = true;
    };
    canvas.addEventListener("wheel", wheel, { passive: false });
  }

  private pinch(before: PointerEvent, now: PointerEvent, other: PointerEvent): void {
    const apart = (one: PointerEvent): number => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
    const middle = { clientX: (now.clientX + other.clientX) / 2, clientY: (now.clientY + other.clientY) / 2 };
    this.camera.closer(apart(now) / Math.max(apart(before), 1), ...this.on(middle), this.stage.aspect);
  }

  private keys(): void {
    const { player } = this;
    const closer = (factor: number): void => {
      this.camera.closer(factor, 0, 0, this.stage.aspect);
      this.dirty = true;
    };
    const actions: Record<string, () => void> = {
      " ": () => player.toggle(), ArrowRight: () => player.step(1), ArrowLeft: () => player.step(-1),
      Home: () => player.seek(0), End: () => player.seek(player.end), "+": () => player.faster(2),
      "=": () => player.faster(2), "-": () => player.faster(0.5), "]": () => closer(1.25), "[": () => closer(0.8),
      l: () => (player.loop = !player.loop), s: () => (player.smooth = !player.smooth), d: () => this.otherLight(),
      p: () => this.save(), f: () => (this.follow = !this.follow),
      r: () => { this.camera.reset(); this.dirty = true; },
    }; // prettier-ignore
    document.addEventListener("keydown", (event) => {
      const where = event.target as HTMLElement;
      if (["INPUT", "SELECT", "TEXTAREA"].includes(where.tagName) && event.key !== " ") return;
      if (where.tagName === "BUTTON" || where.tagName === "SUMMARY") {
        if (event.key === " " || event.key === "Enter") return;
      }
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  private save(): void {
    this.draw();
    const link = document.createElement("a");
    link.download = "ecume.png";
    link.href = this.canvas.toDataURL("image/png");
    link.click();
  }

  /** Follow a run in progress: new frames, and at the end how it ended. */
  private live(): void {
    const server = new Server();
    const stop = element("stop");
    stop.hidden = false;
    stop.addEventListener("click", () => void server.stop().then(() => (stop.textContent = "stopping …")));
    const ask = async (): Promise<void> => {
      const atEnd = this.player.frame >= this.player.end && !this.player.playing;
      const news = await server.news(this.run);
      if (news.chunk) {
        this.run.append(news.chunk);
        this.color(this.choice.coloring);
        this.curves.renew();
        if (atEnd) this.player.seek(this.player.end);
        else this.refresh();
      }
      document.body.dataset.state = news.state;
      if (news.state === "running") window.setTimeout(() => void ask().catch(lost), ASK_EVERY);
      else [stop.textContent, (stop as HTMLButtonElement).disabled] = [news.state, true];
    };
    const lost = (error: Error): void => trouble(`The server of the run does not respond: ${error.message}`);
    void ask().catch(lost);
  }
}

function trouble(text: string): void {
  const room = element("trouble");
  room.hidden = false;
  room.textContent = text;
}

embedded()
  .then((run) => new Page(run, element("canvas") as HTMLCanvasElement))
  .catch((error: Error) => trouble(`This page cannot show the run: ${error.message}.`));
