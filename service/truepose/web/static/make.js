// Forms that have something made: what they ask is the API's own, and the page of what was made comes next.
// They are found when they are sent, so that a part of a page may be replaced while somebody looks at it.

import { filled, followed, post, sayingIn } from "./api.js";

// Dots in a name lead into the body; several entries of one name are a list; what is empty is left out.
function bodyOf(form, ask) {
  const body = structuredClone(ask.body);
  for (const entry of form.querySelectorAll("[name]")) {
    if (!entry.value.trim()) continue;
    const path = entry.name.split(".");
    const last = path.pop();
    const place = path.reduce((inside, name) => (inside[name] ??= {}), body);
    const value = "number" in entry.dataset ? Number(entry.value) : entry.value.trim();
    const several = form.querySelectorAll(`[name="${entry.name}"]`).length > 1;
    place[last] = several ? [...(place[last] ?? []), value] : value;
  }
  return body;
}

// One request after another, each told the number of what the one before made: under a name that was told
// already, the same number again.
async function make(form, say) {
  const { making, unreachable } = form.dataset;
  let number = null;
  const told = {};
  for (const ask of JSON.parse(form.dataset.asks)) {
    if (ask.takes) told[ask.takes] ??= number;
    const body = ask.takes ? { ...ask.body, [ask.takes]: told[ask.takes] } : bodyOf(form, ask);
    say(filled(making, { message: "", percent: 0 }));
    let made = await post(ask.path, body, unreachable);
    const sayDone = ({ fraction, message }) =>
      say(filled(making, { message, percent: Math.round(100 * fraction) }));
    if (made.fraction !== undefined) made = await followed(made, unreachable, sayDone, say);
    if (["failed", "cancelled", "interrupted"].includes(made.state)) throw new Error(made.message);
    number = made.result_id ?? made.id; // of a job, or of what was made at once
  }
  return number;
}

document.addEventListener("submit", async (event) => {
  const form = event.target.closest("form[data-asks]");
  if (!form) return;
  event.preventDefault();
  await sayingIn(form, async (say) => {
    const number = await make(form, say);
    const { leads } = form.dataset;
    if (leads) location.assign(`${leads}/${number}`);
    else location.reload();
  });
});
