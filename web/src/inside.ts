// The simulation in the page: a worker, asked as a server is.

import type { Asking, Told } from "./asking";
import { bytes, element } from "./toy";

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
