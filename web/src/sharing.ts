// A link whose fragment holds the bowl as it is now: where it opens, and how it is handed over.

import { drawCode } from "./code";
import type { Inside } from "./inside";
import { element } from "./toy";

/** The frame of this page in a page of several simulations; null in any other frame, and where there is none. */
const FRAME = ownFrame();
/** The address that links begin with. */
const AROUND = FRAME ? window.parent.location : location;
const LOCAL = AROUND.protocol === "file:" || ["127.0.0.1", "localhost", "[::1]"].includes(AROUND.hostname);
/** The program that gave the page out answers nobody without its token, which stays here. */
const GUARDED = new URLSearchParams(AROUND.search).has("token");

/** Whether the page has an address: one that is written into a frame of another page has none. */
const addressed = ["file:", "http:", "https:"].includes(AROUND.protocol);

function ownFrame(): HTMLElement | null {
  try {
    const frame = window.frameElement as HTMLElement | null;
    return frame?.dataset.name === undefined ? null : frame;
  } catch {
    return null;
  }
}

/** The fragment that an address of this page has, without the name that a page of several puts before it. */
function arrived(): string {
  return FRAME ? FRAME.dataset.fragment! : location.hash.slice(1).split(".").pop()!;
}

/** What is handed over: a link, or what makes one behind the address of another page. */
function handed(fragment: string): string {
  return GUARDED ? fragment : AROUND.href.split("#")[0] + fragment;
}

function where(): string {
  if (GUARDED) return " Put it behind the address of a page that `ecume view` saved of this scene: this page opens on this machine only.";
  return LOCAL ? " It opens on this machine only: others need the file, or the page from a site." : "";
}

/** Show a link and its code, and copy it where that is allowed; what is said of it. */
async function share(link: string, what: string): Promise<string> {
  const fragment = FRAME ? `#${FRAME.dataset.name}.${link}` : `#${link}`;
  const address = handed(fragment);
  const page = FRAME ? window.parent : window;
  if (page === window.top) page.history.replaceState(null, "", fragment);
  const shown = element<HTMLInputElement>("address");
  shown.value = address;
  shown.onfocus = () => shown.select();
  element("code").hidden = LOCAL || !drawCode(element("code"), address);
  element("link-row").hidden = false;
  const copied = await navigator.clipboard?.writeText(address).then(() => true, () => false);
  const said = copied ? `The link is copied: it holds the ${what} as it is now.` : `The link beside the ${what} holds the ${what} as it is now.`;
  return said + where();
}

/** The button that makes a link of what is there; what a link brings is brought, now and when another one comes. */
export async function offerLinks(inside: Inside, what: string, say: (text: string) => void, bring: (fragment: string) => Promise<unknown>): Promise<void> {
  const arrive = async (): Promise<void> => {
    if (arrived()) await bring(arrived());
  };
  element("link").hidden = !addressed;
  element("link").addEventListener("click", async () => say(await share(await inside.act("link"), what)));
  window.addEventListener("hashchange", () => void arrive());
  await arrive();
}
