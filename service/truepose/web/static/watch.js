// A session read from afar: what it does, the newest value, how far it is. Nothing here can be pressed.

import { EventReader } from "./tablet/common/live.js";
import { Units, numbers } from "./units.js";

const AGAIN_MS = 1000;
const SILENCE_MS = 3000;
const OVER = 401;
const at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
const words = document.body.dataset;
const units = new Units();
const states = JSON.parse(words.states);
let heard_ms = performance.now();
let [attempt, began_ms] = [null, 0];

const write = (place, text) => place.textContent === text || (place.textContent = text);

function sample({ length_mm, distance_mm, state }) {
  const value = length_mm ?? distance_mm ?? null;
  const shown = value === null ? null : units.shown(value, "mm", value === length_mm ? 4 : 3);
  write(at.value, shown ? numbers.number(shown.value, shown.digits) : "–");
  write(at.unit, shown ? ` ${units.symbol("mm")}` : "");
  at.value.parentElement.hidden = value === null && !at.value.dataset.seen;
  if (value !== null) at.value.dataset.seen = "yes";
  document.body.dataset.state = state ?? "";
}

function situation({ question, reason, state, progress, step }) {
  write(at.doing, question || reason || states[state]);
  const names = step?.points?.join("  ") ?? "";
  write(at.state, names);
  const done = progress?.readings ?? progress?.done;
  write(at.progress, progress && done !== undefined ? `${done} / ${progress.planned}` : "");
  document.body.dataset.session = state;
}

const HEARD = { sample, situation };

async function read() {
  attempt = new AbortController();
  began_ms = performance.now();
  const reply = await fetch(`${location.pathname}/live`, { cache: "no-store", signal: attempt.signal });
  if (reply.status === OVER) return end();
  const reader = reply.body.getReader();
  const events = new EventReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    heard_ms = performance.now();
    for (const { event, data } of events.read(part.value)) HEARD[event]?.(JSON.parse(data));
  }
  return true;
}

function end() {
  write(at.link, words.over);
  write(at.value, "–");
  return false;
}

async function follow() {
  while (await read().catch(() => true)) await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
}

setInterval(() => {
  const now_ms = performance.now();
  const silent = now_ms - heard_ms > SILENCE_MS;
  if (silent && now_ms - began_ms > SILENCE_MS) attempt.abort(); // a link that went dead says no end
  if (at.link.textContent !== words.over) write(at.link, silent ? words.silent : "");
  if (silent) write(at.value, "–");
}, AGAIN_MS);
follow();
