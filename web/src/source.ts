// Where chunks come from: the page itself, or the server of a run in progress.

import { Chunk, type ChunkHeader, Run, type RunHeader } from "./run";

function text(id: string): string {
  return document.getElementById(id)?.textContent ?? "";
}

async function inflated(packed: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

function unbase64(coded: string): Uint8Array<ArrayBuffer> {
  const plain = atob(coded);
  const bytes = new Uint8Array(plain.length);
  for (let place = 0; place < plain.length; place++) bytes[place] = plain.charCodeAt(place);
  return bytes;
}

/** The run that stands in the page. */
export async function embedded(): Promise<Run> {
  const run = new Run(JSON.parse(text("run")) as RunHeader);
  for (let number = 0; document.getElementById(`chunk-${number}`); number++) {
    const header = JSON.parse(text(`chunk-${number}`)) as ChunkHeader;
    const bytes = await inflated(unbase64(text(`bytes-${number}`)));
    run.append(new Chunk(header, bytes, run.header.dimension));
  }
  return run;
}

/** The colors of a map, 256 times RGB, for the page as it is now, dark or light. */
export function colorsOf(run: RunHeader, name: string): Uint8Array {
  const dark = document.documentElement.dataset.light === "dark" ? run.dark[name] : undefined;
  return unbase64(dark ?? run.maps[name]);
}

export interface News {
  chunk: Chunk | null;
  state: string; // "running", or how it ended
}

/** Asks the server of a run in progress; the token came with the page's own address. */
export class Server {
  private readonly token = new URLSearchParams(location.search).get("token") ?? "";

  private async ask(path: string, method = "GET"): Promise<Response> {
    const answer = await fetch(path, { method, headers: { "X-Token": this.token }, cache: "no-store" });
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    return answer;
  }

  async news(run: Run): Promise<News> {
    const answer = await this.ask(`frames?from=${run.frames}`);
    const whole = new DataView(await answer.arrayBuffer());
    const length = whole.getUint32(0, true);
    const coded = new TextDecoder().decode(new Uint8Array(whole.buffer, 4, length));
    const told = JSON.parse(coded) as { state: string; chunk: ChunkHeader | null };
    const bytes = whole.buffer.slice(4 + length) as ArrayBuffer;
    return { state: told.state, chunk: told.chunk ? new Chunk(told.chunk, bytes, run.header.dimension) : null };
  }

  async stop(): Promise<void> {
    await this.ask("stop", "POST");
  }
}
