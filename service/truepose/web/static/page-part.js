// The page as it is by now, in place of what it was: the server writes it, and what had the focus keeps it.

import { Unanswered } from "./api.js";

const BUSY = 503;

// `address`: of the page, where it is asked for in another state than the one it is read in.
export async function inPage(selector, unreachable, address = location.href) {
  const reply = await fetch(address).catch(() => null);
  if (!reply?.ok) throw await whyNot(reply, unreachable);
  const fresh = new DOMParser().parseFromString(await reply.text(), "text/html").querySelector(selector);
  if (!fresh) return location.assign(reply.url); // to sign in again, for one
  const focus = addressOf(document.activeElement);
  document.querySelector(selector).replaceWith(fresh);
  if (focus) document.querySelector(focus)?.focus({ preventScroll: true });
  return undefined;
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
