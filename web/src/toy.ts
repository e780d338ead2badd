// What the pages of all toys share: the speeds, what is said, the scene to keep, and asking again and again how all stands.

import { server, type Asking, type Told } from "./asking";

export const DEGREE = Math.PI / 180;

export function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

/** What the page was told once. */
export function header<T>(): T {
  return JSON.parse(document.getElementById("toy")!.textContent!) as T;
}

export function bytes(coded: string): Uint8Array {
  return Uint8Array.from(atob(coded), (one) => one.charCodeAt(0));
}

/** The one of two colors, or maps of colors, that the page needs as it is now: light or dark. */
export function themed<T>([light, dark]: [T, T]): T {
  return window.matchMedia("(prefers-color-scheme: dark)").matches ? dark : light;
}

/** Paint the scale of colors. */
export function paintBar(map: Uint8Array): void {
  const image = new ImageData(256, 1);
  for (let place = 0; place < 256; place++) image.data.set([...map.subarray(3 * place, 3 * place + 3), 255], 4 * place);
  element<HTMLCanvasElement>("bar").getContext("2d")!.putImageData(image, 0, 0);
}

/** Buttons of which one is on, as radio buttons are for the keyboard: arrows go from one to the next. */
export function choices(into: HTMLElement, buttons: HTMLButtonElement[], chosen: number, choose: (number: number) => void): void {
  const mark = (number: number): void =>
    buttons.forEach((button, k) => {
      button.setAttribute("aria-checked", String(k === number));
      button.tabIndex = k === number ? 0 : -1;
    });
  buttons.forEach((button, number) => {
    button.setAttribute("role", "radio");
    button.addEventListener("click", () => {
      mark(number);
      choose(number);
    });
    button.addEventListener("keydown", ({ key }) => {
      const way = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[key];
      if (!way) return;
      const next = buttons[(number + way + buttons.length) % buttons.length];
      next.focus();
      next.click();
    });
  });
  mark(chosen);
  into.replaceChildren(...buttons);
}

/** A slider with what it says. */
export function slider(label: string, of: string, range: { min: number; max: number; step: number; value: number }, tell: (value: number) => string, set: (value: number) => Promise<boolean>): HTMLLabelElement {
  const [row, input, told] = [document.createElement("label"), document.createElement("input"), document.createElement("output")];
  Object.assign(input, { type: "range", ...Object.fromEntries(Object.entries(range).map(([key, one]) => [key, String(one)])) });
  input.setAttribute("aria-label", `${label} of ${of}`);
  let stood = range.value;
  const show = (value: number): void => {
    told.textContent = tell(value);
    input.setAttribute("aria-valuetext", told.textContent);
  };
  input.addEventListener("input", () => show(Number(input.value)));
  input.addEventListener("change", async () => {
    if (await set(Number(input.value))) stood = Number(input.value);
    else input.value = String(stood);
    show(stood);
  });
  show(stood);
  row.append(label, told, input);
  return row;
}

export abstract class Toy<T extends Told> {
  protected seen: T | null = null;
  private drawn = 0;
  private heard = 0;

  protected constructor(
    protected readonly name: string,
    title: string,
    speeds: number[],
    protected readonly asking: Asking = server,
  ) {
    element("title").textContent = title;
    document.title = title;
    for (const speed of speeds) this.speed(speed);
    element("save").addEventListener("click", () => void this.save());
    window.addEventListener("resize", () => this.seen && this.draw(this.seen));
  }

  /** What is seen. */
  protected abstract draw(seen: T): void;

  /** What is said beside the picture. */
  protected abstract tell(seen: T): void;

  protected async follow(): Promise<void> {
    for (;;) {
      try {
        this.seen = await this.asking.now<T>();
      } catch {
        this.say(`The program that this ${this.name} runs in has ended.`);
        document.body.dataset.state = "ended";
        return;
      }
      this.draw(this.seen);
      this.tell(this.seen);
      this.mark(this.seen);
      if (!this.drawn) performance.mark("ready");
      document.body.dataset.drawn = String(++this.drawn);
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
  }

  /** The speed that is on, and what happened by itself. */
  private mark({ speed, news }: T): void {
    for (const button of element("speeds").children) {
      button.setAttribute("aria-pressed", String(Number((button as HTMLElement).dataset.value) === speed));
    }
    if (news.length > this.heard) this.say(news[news.length - 1]);
    this.heard = news.length;
  }

  protected slow({ speed, pace }: T): string {
    return speed > 0 && pace < 0.9 ? `, slow motion ${(speed * pace).toPrecision(2)}×` : "";
  }

  private speed(speed: number): void {
    const button = document.createElement("button");
    button.textContent = speed === 0 ? "pause" : speed < 1 ? `1/${1 / speed}×` : `${speed}×`;
    button.dataset.value = String(speed);
    button.addEventListener("click", () => void this.act("speed", { value: speed }));
    element("speeds").append(button);
  }

  /** Do something, and say why it was not done. */
  protected async act(what: string, more: Record<string, unknown> = {}): Promise<boolean> {
    const fault = await this.asking.act(what, more).catch((error: Error) => error.message);
    this.say(fault);
    return !fault;
  }

  protected say(text: string): void {
    const said = element("said");
    if (text || !said.hidden) {
      said.textContent = text;
      said.hidden = !text;
    }
  }

  private async save(): Promise<void> {
    const link = document.createElement("a");
    link.download = `${this.name}.toml`;
    link.href = URL.createObjectURL(new Blob([await this.asking.scene()], { type: "application/toml" }));
    link.click();
    URL.revokeObjectURL(link.href);
  }
}
