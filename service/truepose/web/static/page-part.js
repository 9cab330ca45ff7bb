// The page as it is by now, in place of what it was: the server writes it, and what had the focus keeps it. What is
// pressed stays until it is let go of, or the press would be a tap on nothing; of two pages that were asked for the
// later one stays, whichever arrives first.

import { Unanswered } from "./api.js";
import { isPressed } from "./shell.js";

const BUSY = 503;
const PRESS_MS = 20; // between two looks whether something is still pressed
const asked = new Map(); // how often a part was asked for, by its selector

// `address`: of the page, where it is asked for in another state than the one it is read in.
export async function inPage(selector, unreachable, address = location.href) {
  const turn = (asked.get(selector) ?? 0) + 1;
  asked.set(selector, turn);
  const reply = await fetch(address).catch(() => null);
  if (!reply?.ok) throw await whyNot(reply, unreachable);
  const fresh = new DOMParser().parseFromString(await reply.text(), "text/html").querySelector(selector);
  if (!fresh) return location.assign(reply.url); // to sign in again, for one
  await released(selector);
  if (asked.get(selector) !== turn) return undefined;
  const focus = addressOf(document.activeElement);
  document.querySelector(selector).replaceWith(fresh);
  if (focus) document.querySelector(focus)?.focus({ preventScroll: true });
  return undefined;
}

async function released(selector) {
  while (isPressed(document.querySelector(selector))) await new Promise((resolve) => setTimeout(resolve, PRESS_MS));
}

async function whyNot(reply, unreachable) {
  const sentence = (await reply?.json().catch(() => null))?.detail ?? unreachable;
  return !reply || reply.status === BUSY ? new Unanswered(sentence) : new Error(sentence);
}

function addressOf(element) {
  if (!element || element === document.body) return "";
  const file = element.closest("[data-file]");
  const own = ["column", "unit", "text"].find((name) => name in element.dataset);
  const within = file ? `[data-file="${CSS.escape(file.dataset.file)}"] ` : "";
  return own ? `${within}[data-${own}="${CSS.escape(element.dataset[own])}"]` : "";
}
