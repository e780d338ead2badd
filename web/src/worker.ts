// How a worker answers its page: each question by its number.

type Question = Record<string, unknown> & { number: number; what: string; wasm?: BufferSource };
const { postMessage: reply } = globalThis as unknown as { postMessage(answer: unknown): void };

/** What answers questions, once it has begun with compiled code. */
export interface Answering {
  answer(what: string, asked: Record<string, unknown>): unknown;
}

/** Answer all questions; the first one brings the compiled code and what else there is to begin with. */
export function answering(begin: (compiled: unknown, given: Record<string, unknown>) => Answering): void {
  let there: Answering;
  globalThis.onmessage = async ({ data }: MessageEvent<Question>): Promise<void> => {
    const { number, what, ...asked } = data;
    try {
      let answer: unknown;
      if (what === "start") there = begin((await WebAssembly.instantiate(asked.wasm as BufferSource)).instance.exports, asked);
      else answer = there.answer(what, asked);
      reply({ number, answer });
    } catch (fault) {
      reply({ number, fault: String((fault as Error).message ?? fault) });
    }
  };
}
