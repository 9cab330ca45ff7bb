// Forms that have something made: what they ask is the API's own, and the page of what was made comes next.

import { answered, filled, onSubmit, post } from "./api.js";

const POLL_MS = 500;

// Dots in a name lead into the body; several entries of one name are a list; what is empty is left out.
function bodyOf(form) {
  const body = structuredClone(JSON.parse(form.dataset.body));
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

async function make(form, say) {
  const { path, making, leads, unreachable } = form.dataset;
  say(filled(making, { message: "", percent: 0 }));
  let made = await post(path, bodyOf(form), unreachable);
  while (["queued", "running"].includes(made.state)) {
    say(filled(making, { message: made.message, percent: Math.round(100 * made.fraction) }));
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    made = await answered(`/api/v1/jobs/${made.id}`, {}, unreachable);
  }
  if (made.state === "failed") throw new Error(made.message);
  location.assign(`${leads}/${made.result_id ?? made.id}`); // of a job, or of a session at once
}

for (const form of document.querySelectorAll("form[data-path]")) {
  onSubmit(form, (say) => make(form, say));
}
