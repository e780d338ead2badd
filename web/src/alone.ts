// A bowl that simulates in the page: ecume's compiled laws in a worker; nothing leaves the browser.

import type { Asking, Now, Told } from "./asking";
import { BowlPage } from "./bowl";
import type { Bowl } from "./dish";
import type { Alone, Filled, Kept } from "./solver";
import { bytes, element, header } from "./toy";

type Seen = Now & { force: number[]; largest: number };

async function unpacked(id: string): Promise<ArrayBuffer> {
  const packed = new Blob([bytes(element(id).textContent!) as Uint8Array<ArrayBuffer>]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** The worker, asked as a server is. */
class Inside implements Asking {
  private readonly worker: Worker;
  private readonly waiting = new Map<number, { resolve: (answer: unknown) => void; reject: (fault: Error) => void }>();
  private asked = 0;

  constructor() {
    const script = new Blob([element("worker").textContent!], { type: "text/javascript" });
    this.worker = new Worker(URL.createObjectURL(script));
    this.worker.onmessage = ({ data: { number, answer, fault } }) => {
      const { resolve, reject } = this.waiting.get(number)!;
      this.waiting.delete(number);
      if (fault === undefined) resolve(answer);
      else reject(new Error(fault));
    };
  }

  ask<T>(what: string, more: Record<string, unknown> = {}): Promise<T> {
    const number = ++this.asked;
    return new Promise((resolve, reject) => {
      this.waiting.set(number, { resolve: resolve as (answer: unknown) => void, reject });
      this.worker.postMessage({ ...more, number, what });
    });
  }

  now<T extends Told>(): Promise<T> {
    return this.ask("now");
  }

  scene(): Promise<string> {
    return this.ask("scene");
  }

  act(what: string, more: Record<string, unknown> = {}): Promise<string> {
    return this.ask(what, more);
  }
}

/** What a challenge asks for, and whether it is met. */
interface Challenge {
  name: string;
  met(seen: Seen, bowl: Alone): boolean;
  told(seen: Seen, bowl: Alone): string;
}

/** From the nearest float to the middle of the dish outward: distance from the middle over that of the wall. */
function outermost(seen: Seen, { outline }: Alone): number {
  const wall = Math.min(...outline.map(([x, y]) => Math.hypot(x, y)));
  return Math.max(0, ...seen.x.map((x, k) => (Math.hypot(x, seen.y[k]) + seen.radius[k]) / wall));
}

const STAY = 5; // s

const CHALLENGES: Challenge[] = [
  { name: "none", met: () => false, told: () => "" },
  {
    name: "make two floats repel",
    met: (seen) => seen.x.length > 1 && apart(seen, 0, 1) > 0 && pushes(seen),
    told: () => "The nearest two floats must push each other apart: try a light one and a heavy one.",
  },
  {
    name: "keep ten floats off the wall",
    met: (seen, bowl) => seen.x.length >= 10 && outermost(seen, bowl) < 0.9,
    told: (seen, bowl) => `${seen.x.length} of 10 floats; the outermost is at ${(100 * outermost(seen, bowl)).toFixed(0)} % of the radius, below 90 % for ${STAY} s is enough.`,
  },
  {
    name: "build a raft of twelve",
    met: (seen) => seen.largest >= 12,
    told: (seen) => `The largest raft has ${seen.largest} of 12 floats.`,
  },
];

function apart(seen: Seen, one: number, other: number): number {
  return Math.hypot(seen.x[one] - seen.x[other], seen.y[one] - seen.y[other]);
}

/** The nearest two floats, by their numbers. */
function nearest(seen: Seen): [number, number] {
  let [best, pair]: [number, [number, number]] = [Infinity, [0, 1]];
  for (let one = 1; one < seen.x.length; one++) {
    for (let other = 0; other < one; other++) {
      const gap = apart(seen, one, other) - seen.radius[one] - seen.radius[other];
      if (gap < best) [best, pair] = [gap, [other, one]];
    }
  }
  return pair;
}

/** Whether the forces on the nearest two floats part them. */
function pushes(seen: Seen): boolean {
  const [one, other] = nearest(seen);
  const [x, y] = [seen.x[other] - seen.x[one], seen.y[other] - seen.y[one]];
  return (seen.force[2 * other] - seen.force[2 * one]) * x + (seen.force[2 * other + 1] - seen.force[2 * one + 1]) * y > 0;
}

const LABELS: Record<string, (factor: number) => string> = {
  size: (factor) => `${factor} × radius`,
  density: (factor) => `${factor} × density`,
  "contact angle": (more) => (more ? `${more > 0 ? "+" : "−"}${Math.abs(more)}°` : "as it is"),
};

class Page extends BowlPage {
  private history: [time: number, distance: number][] = [];
  private followed = "";
  private since = -1;
  private picked = -1;
  private choices: number[][];

  constructor(
    private readonly inside: Inside,
    private readonly alone: Alone,
    private readonly liquids: Record<string, Filled>,
  ) {
    const bowl: Bowl = { ...alone, grid: 1, shelf: alone.species, speeds: [0, 0.25, 1, 4], map: "" };
    super(bowl, alone.species[0].name, inside);
    this.choices = alone.species.map(() => [...alone.usual]);
    this.shelve(alone.species.map(({ name, color }) => [name, color]));
    element("shelf").addEventListener("click", () => this.offer());
    this.offer();
    const liquid = element<HTMLSelectElement>("liquid");
    liquid.append(...Object.keys(liquids).map((name) => new Option(name)));
    liquid.addEventListener("change", () => void this.act("liquid", { name: liquid.value }));
    const challenge = element<HTMLSelectElement>("challenge");
    challenge.append(...CHALLENGES.map(({ name }) => new Option(name)));
    challenge.addEventListener("change", () => (this.since = -1));
    element("link").addEventListener("click", () => void this.share());
    this.keys();
    window.addEventListener("hashchange", () => void this.bring());
    void this.bring().then(() => this.follow());
  }

  /** Sliders for the kind of the chosen species. */
  private offer(): void {
    const species = this.alone.species.findIndex(({ name }) => name === this.chosen);
    const rows = Object.entries(this.alone.factors).map(([name, factors], factor) => {
      const [row, input, told] = [document.createElement("label"), document.createElement("input"), document.createElement("output")];
      Object.assign(input, { type: "range", min: "0", max: String(factors.length - 1), step: "1", value: String(this.choices[species][factor]) });
      input.setAttribute("aria-label", `${name} of ${this.chosen}`);
      const tell = (): void => {
        told.textContent = LABELS[name](factors[Number(input.value)]);
        input.setAttribute("aria-valuetext", told.textContent);
      };
      input.addEventListener("input", tell);
      input.addEventListener("change", async () => {
        const fault = await this.inside.act("kind", { species, factor, value: Number(input.value) });
        this.say(fault);
        if (!fault) this.choices[species][factor] = Number(input.value);
        else input.value = String(this.choices[species][factor]);
        tell();
      });
      tell();
      row.append(name, told, input);
      return row;
    });
    element("factors").replaceChildren(...rows);
  }

  protected draw(seen: Now): void {
    super.draw(seen);
    const pair = element<HTMLInputElement>("ruler").checked && seen.x.length > 1 ? nearest(seen as Seen) : null;
    if (element<HTMLInputElement>("arrows").checked) this.picture.arrows(seen, (seen as Seen).force);
    if (pair) this.picture.ruler(seen, pair);
    if (this.picked >= 0 && this.picked < seen.x.length) this.picture.ring(seen, this.picked);
    this.remember(seen, pair);
  }

  protected tell(seen: Now): void {
    const { time, x, clusters } = seen;
    element("clock").textContent = `${time.toFixed(1)} s · ${x.length} floats in ${clusters} rafts${this.slow(seen)}`;
    const { liquid, capillary_length } = this.liquids[element<HTMLSelectElement>("liquid").value];
    element("liquid-numbers").textContent = `surface tension ${(1e3 * liquid.surface_tension).toPrecision(3)} mN/m, viscosity ${(1e3 * liquid.viscosity).toPrecision(3)} mPa s, density ${liquid.density.toPrecision(4)} kg/m³`;
    element("length").textContent = `${(1e3 * capillary_length).toFixed(2)} mm`;
    this.judge(seen as Seen);
  }

  private judge(seen: Seen): void {
    const challenge = CHALLENGES[element<HTMLSelectElement>("challenge").selectedIndex];
    if (!challenge.met(seen, this.alone)) this.since = seen.time;
    const state = element("challenge-state");
    const done = this.since >= 0 && challenge.name !== "none" && seen.time - this.since >= STAY;
    const text = done ? "Done!" : challenge.told(seen, this.alone);
    if (state.textContent !== text && state.textContent !== "Done!" || challenge.name === "none") state.textContent = text;
  }

  /** Draw the distance of the two floats over the last half minute. */
  private remember(seen: Now, pair: [number, number] | null): void {
    const which = String(pair);
    if (which !== this.followed) [this.history, this.followed] = [[], which];
    const plot = element<HTMLCanvasElement>("plot");
    const on = plot.getContext("2d")!;
    on.clearRect(0, 0, plot.width, plot.height);
    const style = getComputedStyle(document.documentElement);
    on.font = "22px system-ui";
    on.fillStyle = style.getPropertyValue("--muted");
    if (!pair) {
      on.fillText("switch the ruler on", 12, 36);
      return;
    }
    this.history.push([seen.time, apart(seen as Seen, ...pair)]);
    this.history = this.history.filter(([time]) => time > seen.time - 30).slice(-1000);
    const most = Math.max(...this.history.map(([, distance]) => distance));
    on.fillText(`${(1e3 * this.history[this.history.length - 1][1]).toFixed(2)} mm`, 12, 26);
    on.strokeStyle = style.getPropertyValue("--accent");
    on.lineWidth = 3;
    on.beginPath();
    for (const [time, distance] of this.history) {
      on.lineTo(plot.width * (1 - (seen.time - time) / 30), plot.height - 4 - ((plot.height - 44) * distance) / most);
    }
    on.stroke();
  }

  /** All that hands do, by keys. */
  private keys(): void {
    const ways: Record<string, [number, number]> = { a: [-1, 0], d: [1, 0], w: [0, 1], s: [0, -1] };
    this.canvas.addEventListener("keydown", (event) => {
      const { seen, picked } = this;
      const key = event.key.toLowerCase();
      if (!seen || event.ctrlKey || event.metaKey || event.altKey) return;
      const there = picked >= 0 && picked < seen.x.length;
      if (key === "n" && seen.x.length) this.picked = (picked + 1) % seen.x.length;
      else if (key === "x" && there) void this.act("take", { one: picked });
      else if (key === "enter") void this.middle();
      else if (key in ways && there) {
        const far = 12 * seen.radius[picked];
        void this.act("grasp", { one: picked, x: seen.x[picked] + far * ways[key][0], y: seen.y[picked] + far * ways[key][1] });
      } else return;
      event.preventDefault();
    });
    this.canvas.addEventListener("keyup", (event) => event.key.toLowerCase() in ways && void this.act("release"));
  }

  /** Drop a float as near the middle as there is room. */
  private async middle(): Promise<void> {
    const step = this.alone.species.find(({ name }) => name === this.chosen)!.radius;
    for (let k = 0; k < 200; k++) {
      const [away, angle] = [step * Math.sqrt(k), 2.4 * k];
      const fault = await this.inside.act("drop", { name: this.chosen, x: away * Math.cos(angle), y: away * Math.sin(angle) });
      if (fault !== "There is no room here.") return this.say(fault);
    }
    this.say("There is no room here.");
  }

  /** A link whose fragment holds the bowl as it is. */
  private async share(): Promise<void> {
    const kept = await this.inside.act("keep");
    history.replaceState(null, "", `#${encodeURIComponent(kept)}`);
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    this.say(copied ? "The link is copied: it holds the bowl as it is now." : "The address of this page now holds the bowl as it is.");
  }

  private async bring(): Promise<void> {
    if (location.hash.length < 2) return;
    let kept: Kept | null = null;
    try {
      kept = JSON.parse(decodeURIComponent(location.hash.slice(1))) as Kept;
    } catch {
      // Said below.
    }
    const fault = await this.inside.act("bring", { kept });
    this.say(fault);
    if (fault || !kept) return;
    element<HTMLSelectElement>("liquid").value = kept.liquid;
    this.choices = kept.choices.map((choice) => [...choice]);
    this.offer();
  }
}

async function begin(): Promise<void> {
  const [alone, inside] = [header<Alone>(), new Inside()];
  const [wasm, packed] = await Promise.all([unpacked("wasm"), unpacked("liquids")]);
  const liquids = JSON.parse(new TextDecoder().decode(packed)) as Record<string, Filled>;
  await inside.ask("start", { wasm, alone, liquids });
  new Page(inside, alone, liquids);
}

begin().catch((fault: Error) => {
  const said = element("said");
  said.textContent = `This browser cannot simulate here: ${fault.message}`;
  said.hidden = false;
});
