// What a person says of their files goes to the service at once; the page is then as the service understands it.

import { answerTo, answered, post } from "./api.js";
import { inPage } from "./page-part.js";

const POLL_MS = 500;
const page = () => document.querySelector("#draft");
const address = () => `/api/v1/drafts/${page().dataset.draft}`;
const unreachable = () => page().dataset.unreachable;

let underWay = 0;

function showWhetherBusy() {
  page().ariaBusy = underWay > 0 ? "true" : null;
}

async function doing(act) {
  underWay += 1;
  showWhetherBusy();
  try {
    await act();
    await inPage("#draft", unreachable());
    begin();
  } catch (error) {
    const said = page().querySelector("output.said");
    said.textContent = error.message;
    said.classList.add("bad");
  } finally {
    underWay -= 1;
    showWhetherBusy();
  }
}

function say(document_) {
  const headers = { "Content-Type": "application/json" };
  return doing(() => answered(address(), { method: "PATCH", headers, body: JSON.stringify(document_) }, unreachable()));
}

const sayOfFile = (name, said) => say({ files: { [name]: said } });
const fileOf = (element) => element.closest("[data-file]").dataset.file;

// A day of the calendar where the person is, not of Greenwich.
function dayBefore(days) {
  const day = new Date();
  day.setDate(day.getDate() - days);
  return [day.getFullYear(), day.getMonth() + 1, day.getDate()].map((part) => String(part).padStart(2, "0")).join("-");
}

const sayDay = (day) =>
  say({ measured_on: day, measured_zone: Intl.DateTimeFormat().resolvedOptions().timeZone || null });

function sayColumn(select, meaning) {
  return sayOfFile(fileOf(select), { columns: { [select.dataset.column]: meaning } });
}

// A coordinate stays that of its point, where a row has several.
function pointed(column, meaning) {
  return meaning.quantity === "position" ? { ...meaning, point: Number(column.dataset.point) } : meaning;
}

const CHANGED = {
  role: (element) => sayOfFile(fileOf(element), { role: element.value }),
  column: (element) => {
    const meaning = JSON.parse(element.value);
    return sayColumn(element, pointed(element, meaning));
  },
  unit: (element) => {
    const column = element.closest("th").querySelector("[data-column]");
    const meaning = JSON.parse(column.selectedOptions[0].value);
    return sayColumn(column, pointed(column, { ...meaning, unit: element.value }));
  },
  sayValue: (element) => element.value && say(JSON.parse(element.value)),
  number: (element) => element.value && say({ [element.dataset.number]: Number(element.value) }),
  date: (element) => element.value && sayDay(element.value),
  text: (element) => say({ [element.dataset.text]: element.value.trim() || null }),
};

const CLICKED = {
  say: (element) => say(JSON.parse(element.dataset.say)),
  day: (element) => sayDay(dayBefore(Number(element.dataset.day))),
  leaveOut: (element) => sayOfFile(fileOf(element), { left_out: [...leftOut(element), Number(element.form.dataset.line)] }),
  remove: (element) =>
    doing(() => answered(`${address()}/files?number=${element.dataset.remove}`, { method: "DELETE" }, unreachable())),
  go: () => doing(() => post(`${address()}/campaign`, {}, unreachable())),
};

const leftOut = (element) => JSON.parse(element.form.dataset.leftOut || "[]");

function handled(table, element) {
  const name = element && Object.keys(table).find((key) => key in element.dataset);
  if (name) table[name](element);
}

document.addEventListener("change", (event) => handled(CHANGED, event.target));
document.addEventListener("click", (event) => handled(CLICKED, event.target.closest("button")));
document.addEventListener("submit", (event) => {
  const { line } = event.target.dataset;
  event.preventDefault();
  if (line) sayOfFile(fileOf(event.target), { lines: { [line]: event.target.elements.text.value } });
});
document.addEventListener("changed", () => doing(async () => {}), true);

// What a column can be is a long list: it is put into a select when somebody opens it.
function opened(event) {
  const select = event.target.closest?.("select[data-column]");
  if (!select || select.options.length > 1) return;
  const now = JSON.parse(select.value);
  for (const option of document.querySelector("#meanings").content.children) {
    const meaning = JSON.parse(option.value);
    if (meaning.quantity !== now.quantity || meaning.number !== now.number) select.append(option.cloneNode(true));
  }
}
for (const kind of ["pointerdown", "focusin"]) document.addEventListener(kind, opened);

async function follow() {
  const jobs = document.querySelector("[data-jobs]:not([data-ended])");
  if (!jobs) return;
  let last;
  for (const number of jobs.dataset.jobs.split(",")) {
    last = await answerTo(() => answered(`/api/v1/jobs/${number}`, {}, unreachable()));
    const card = jobs.querySelector(`[data-job="${number}"]`);
    card.querySelector("progress").value = last.state === "succeeded" ? 1 : last.fraction;
    card.querySelector("span").textContent = last.message;
    if (["failed", "cancelled", "interrupted"].includes(last.state)) return doing(async () => {});
  }
  if (last.state === "succeeded") location.assign(`/diagnoses/${last.result_id}`);
  else setTimeout(follow, POLL_MS);
}

// The marked cell of a wide table is in sight.
function showFault() {
  document.querySelector("td[aria-invalid]")?.scrollIntoView({ inline: "center", block: "nearest" });
}

function showDayAnswered() {
  const said = document.querySelector("[data-date]")?.value;
  for (const button of document.querySelectorAll("[data-day]")) {
    button.ariaPressed = String(dayBefore(Number(button.dataset.day)) === said);
  }
}

// Nothing can be tapped before somebody listens.
function begin() {
  showDayAnswered();
  page().removeAttribute("inert");
  showFault();
  follow();
}

begin();
