// The simulation in the page: a worker, asked as a server is.

import type { Asking, Told } from "./asking";
import { bytes, element } from "./toy";

/** What is packed in an element of the page. */
export async function unpacked(id: string): Promise<ArrayBuffer> {
  const packed = new Blob([bytes(element(id).textContent!) as Uint8Array<ArrayBuffer>]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

export class Inside implements Asking {
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

/** The simulation in the page, begun, with what it begins with beside what is given: the numbers under the name `of`. */
export async function begun<T>(of: string, given: Record<string, unknown> = {}): Promise<[Inside, T]> {
  const inside = new Inside();
  const [wasm, packed] = await Promise.all([unpacked("wasm"), unpacked(of)]);
  const numbers = JSON.parse(new TextDecoder().decode(packed)) as T;
  await inside.ask("start", { ...given, wasm, [of]: numbers });
  return [inside, numbers];
}

/** Begin a page, or say why it cannot. */
export function beginning(begin: () => Promise<void>): void {
  begin().catch((fault: Error) => {
    const said = element("said");
    said.textContent = `This browser cannot simulate here: ${fault.message}`;
    said.hidden = false;
  });
}
