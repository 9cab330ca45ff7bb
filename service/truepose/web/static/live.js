// Parts of a page that are as the service has them now: whenever something happens, the page is asked for again and
// what changed in them is put in place. What somebody holds or has sent stays until they are done.

import { holdControls, isPressed } from "./shell.js";

const KINDS = [
  "session.state", "session.progress", "session.reading", "session.entry", "session.stops_added", "session.stop_skipped",
  "session.identity", "session.registered", "job.state", "job.progress", "campaign.stored",
];
const FAILED = 500;
const PAUSE_MS = 700; // between two requests for the page
const LOST_MS = 1500;
const lost = document.querySelector("[data-lost]");
let wanted = false;
let busy = false;

const inUse = (part) => isPressed(part) || part.querySelector("[aria-busy=true], dialog[open]");

function place(fresh) {
  for (const part of document.querySelectorAll("[data-live]")) {
    const now = fresh.getElementById(part.id);
    if (!now || now.innerHTML === part.innerHTML || inUse(part)) continue;
    part.replaceChildren(...now.childNodes);
    holdControls(part);
  }
  const goes = fresh.querySelector("[data-goes]")?.dataset.goes;
  if (goes) location.replace(goes);
}

async function refresh() {
  wanted = true;
  if (busy) return;
  busy = true;
  while (wanted) {
    wanted = false;
    try {
      const reply = await fetch(location.href, { headers: { Accept: "text/html" } });
      wanted ||= reply.status >= FAILED; // said by something that may do better in a moment
      if (reply.ok) place(new DOMParser().parseFromString(await reply.text(), "text/html"));
    } catch {
      wanted = true; // the service is away: until it answers
    }
    await new Promise((resolve) => setTimeout(resolve, PAUSE_MS));
  }
  busy = false;
}

const events = new EventSource("/api/v1/events");
let away = null;
events.addEventListener("error", () => {
  away ??= setTimeout(() => (lost.hidden = false), LOST_MS);
});
events.addEventListener("open", () => {
  clearTimeout(away);
  away = null;
  lost.hidden = true;
  refresh(); // what happened before the stream was open
});
for (const kind of KINDS) events.addEventListener(kind, refresh);
document.addEventListener("visibilitychange", () => document.hidden || refresh());
