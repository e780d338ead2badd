// What stands beside the picture: the particle that was chosen, the run's facts, its papers, its scene.

import type { Instant, Run } from "./run";
import { told } from "./told";

export function element(id: string): HTMLElement {
  return document.getElementById(id)!;
}

function terms(list: HTMLElement, rows: [string, string][]): void {
  list.replaceChildren();
  for (const [name, value] of rows) {
    const [term, description] = [document.createElement("dt"), document.createElement("dd")];
    [term.textContent, description.textContent] = [name, value];
    list.append(term, description);
  }
}

/** All text comes from a scene that anybody may have written: it is set as text, never as markup. */
export function fill(run: Run): void {
  const { header } = run;
  element("title").textContent = header.title;
  document.title = header.title;
  element("scene").textContent = header.scene;
  terms(element("facts"), header.facts);
  for (const paper of header.papers) {
    const item = document.createElement("li");
    item.textContent = `${paper.text} [${paper.key}]`;
    element("papers").append(item);
  }
  element("cite").hidden = !header.papers.length;
  for (const species of header.species) {
    const item = document.createElement("span");
    item.textContent = species.name;
    item.style.setProperty("--kind", species.color);
    if (header.species.length > 1) element("kinds").append(item);
  }
}

export function inspect(run: Run, instant: Instant, chosen: number): void {
  const room = element("inspector");
  room.hidden = chosen < 0 || chosen >= instant.count;
  if (room.hidden) return;
  const { header } = run;
  const d = header.dimension;
  const place = Array.from(instant.position.subarray(d * chosen, d * chosen + d));
  const rows: [string, string][] = [["position", place.map((value) => told(value, "m")).join(", ")]];
  const kind = header.species[instant.arrays["species"]?.[chosen] ?? -1];
  if (kind) rows.unshift(["species", kind.name]);
  for (const { name, unit } of header.colorings) {
    const value = instant.arrays[name]?.[chosen];
    if (value !== undefined) rows.push([name.replaceAll("_", " "), told(value, unit)]);
  }
  const heading = document.createElement("strong");
  const carried = header.apart !== null && (instant.arrays["species"]?.[chosen] ?? 0) >= header.apart;
  heading.textContent = carried ? `particle ${chosen}, carried by the liquid` : `particle ${chosen}`;
  const list = document.createElement("dl");
  terms(list, rows);
  room.replaceChildren(heading, list);
}
