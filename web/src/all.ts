// A page of several simulations: each is a page of its own in a frame, and only the chosen one is there.

import { unpacked } from "./inside";
import { choices, element, header } from "./toy";

interface Shown {
  name: string; // in links, before the fragment of its page
  label: string;
}

const shown = header<Shown[]>();
const frame = element<HTMLIFrameElement>("frame");

/** Which simulation a link names, and what the link brings to it. */
function named(): [number, string] {
  const [name, fragment = ""] = location.hash.slice(1).split(".");
  const number = shown.findIndex((each) => each.name === name);
  return number < 0 ? [0, location.hash.slice(1)] : [number, fragment];
}

/** Show a simulation, as it begins or as a link says. */
async function show(number: number, fragment: string): Promise<void> {
  const { name, label } = shown[number];
  const text = new TextDecoder().decode(await unpacked(`page-${number}`));
  const fresh = frame.cloneNode() as HTMLIFrameElement;
  document.getElementById("frame")!.replaceWith(fresh);
  [fresh.dataset.name, fresh.dataset.fragment, fresh.title] = [name, fragment, label];
  fresh.srcdoc = text;
  document.body.dataset.shown = name;
}

/** Show another simulation as it begins. The address no longer names the one before, nor what a link brought to it. */
function choose(number: number): void {
  if (window === window.top) history.replaceState(null, "", `#${shown[number].name}`);
  void show(number, "");
}

function begin(): void {
  const [first, fragment] = named();
  const buttons = shown.map(({ label }) => Object.assign(document.createElement("button"), { textContent: label }));
  choices(element("toys"), buttons, first, choose);
  void show(first, fragment);
}

window.addEventListener("hashchange", begin);
begin();
