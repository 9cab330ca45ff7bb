// The faults of a simulated cell: what was given and what became of it, and a form for each kind.

import { answered, filled, onSubmit, post } from "./api.js";

const POLL_MS = 1000;
const PATH = "/api/v1/simulated-faults";
const at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
const { struck, file, end, unreachable } = at.given.dataset;
const [states, names] = [JSON.parse(at.given.dataset.states), JSON.parse(at.given.dataset.names)];
const person = at.who.elements.person;

person.value = sessionStorage.getItem("person") ?? person.value;
at.who.addEventListener("submit", (event) => event.preventDefault());

function named() {
  const name = person.value.trim();
  sessionStorage.setItem("person", name);
  if (!person.reportValidity()) throw new Error("");
  return name;
}

const OF = {
  number: (text) => Number(text.replace(",", ".")),
  whole: (text) => Number(text),
  text: (text) => text,
  vector: (text) => text.split(/[\s;]+/).map((part) => Number(part.replace(",", "."))),
};

function keysOf(form) {
  const keys = {};
  for (const field of form.querySelectorAll("[data-type]")) {
    const text = field.value.trim();
    if (text) keys[field.name] = OF[field.dataset.type](text);
  }
  const trigger = form.querySelector("[data-trigger]").value;
  if (trigger) keys[trigger] = OF.number(form.querySelector("[data-at]").value);
  return keys;
}

function cell(row, text) {
  row.insertCell().textContent = text;
}

function seconds(time_s) {
  return time_s === null ? "" : time_s.toFixed(1);
}

function endButton(number) {
  const button = document.createElement("button");
  button.textContent = end;
  button.addEventListener("click", async () => {
    try {
      at.said.textContent = "";
      const who = { method: "POST", headers: { "Content-Type": "application/json" } };
      const reply = await fetch(`${PATH}/${number}/end`, { ...who, body: JSON.stringify({ person: named() }) });
      if (!reply.ok) at.said.textContent = (await reply.json()).detail;
    } catch (error) {
      at.said.textContent = error.message && unreachable;
    }
    await look();
  });
  return button;
}

function show({ now_s, faults }) {
  at.now.textContent = filled(at.now.dataset.now, { seconds: now_s.toFixed(1) });
  at.none.hidden = faults.length > 0;
  at.given.hidden = faults.length === 0;
  const rows = at.given.querySelector("tbody");
  rows.replaceChildren();
  for (const fault of faults.reverse()) {
    const row = rows.insertRow();
    row.dataset.state = fault.state;
    cell(row, fault.number);
    cell(row, names[fault.kind] ?? fault.kind);
    cell(row, Object.entries(fault.keys).map(([key, value]) => `${key} = ${value}`).join(", "));
    cell(row, [states[fault.state], fault.struck ? filled(struck, { count: fault.struck }) : ""].filter(Boolean).join(", "));
    cell(row, `${seconds(fault.begun_s)} – ${seconds(fault.over_s)}`);
    cell(row, fault.person ?? file);
    const last = row.insertCell();
    if (fault.state !== "over") last.append(endButton(fault.number));
  }
}

async function look() {
  try {
    show(await answered(PATH, {}, unreachable));
  } catch (error) {
    at.now.textContent = error.message;
  }
}

for (const form of document.querySelectorAll("form[data-kind]")) {
  const value = form.querySelector("[data-at]");
  const trigger = form.querySelector("[data-trigger]");
  trigger.addEventListener("change", () => {
    value.parentElement.hidden = !trigger.value;
    value.required = Boolean(trigger.value);
  });
  onSubmit(form, async (say) => {
    say("");
    const wanted = { person: named(), kind: form.dataset.kind, keys: keysOf(form) };
    say(filled(form.dataset.done, await post(PATH, wanted, unreachable)));
    await look();
  });
}

await look();
setInterval(look, POLL_MS);
