// Runs the worker of a page as Node does: node worker.mjs PAGE, with a list of questions [what, more] on stdin as JSON.
// The fragment "@link" is the last link that was made.
import { readFileSync } from "node:fs";
import vm from "node:vm";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const text = (id) => page.match(new RegExp(`id="${id}">([^]*?)</script>`))[1];
const bytes = (id) => gunzipSync(Buffer.from(text(id), "base64"));
const waiting = [];
globalThis.postMessage = ({ number, answer, fault }) => waiting[number]({ answer, fault });
vm.runInThisContext(text("worker"));
const ask = (what, more = {}) =>
  new Promise((resolve) => globalThis.onmessage({ data: { ...more, what, number: waiting.push(resolve) - 1 } }));
const [toy, packed] = [JSON.parse(text("toy")), (id) => JSON.parse(bytes(id))];
const given = page.includes('id="liquids"') ? { alone: toy, liquids: packed("liquids") } : { cases: packed("cases") };
const start = { wasm: bytes("wasm"), ...given };
const answers = [await ask("start", start)];
let link = "";
for (const [what, more] of JSON.parse(readFileSync(0, "utf8"))) {
  answers.push(await ask(what, more?.fragment === "@link" ? { fragment: link } : more));
  if (what === "link") link = answers[answers.length - 1].answer;
}
console.log(JSON.stringify(answers.slice(1)));
