// The buttons below a diagnosis of a session: measure what it proposes, and diagnose again, without the readings
// that were set aside or with all of them.
// What they ask is the API's own; whatever it answers is said in its own sentence. The page brings the words.

import { filled, followed, post as asked } from "./api.js";

const bar = document.querySelector("[data-session]");
const form = bar.querySelector("form");
const agains = bar.querySelectorAll("[data-again]");
const said = bar.querySelector("output");
const session = `/api/v1/sessions/${bar.dataset.session}`;

const post = (path, body, key) => asked(path, body, bar.dataset.unreachable, key);

function say(sentence, bad = false) {
  said.textContent = sentence;
  said.classList.toggle("bad", bad);
}

async function busy(work) {
  const buttons = bar.querySelectorAll("button");
  buttons.forEach((button) => (button.disabled = true));
  try {
    await work();
  } catch (error) {
    say(error.message, true);
  } finally {
    buttons.forEach((button) => (button.disabled = false));
  }
}

async function measure() {
  const configurations = JSON.parse(form.dataset.configurations).map((joints) => ({ joints_deg: joints }));
  // Named, the diagnosis is run again by itself once the session has finished.
  const diagnosis_id = Number(bar.dataset.diagnosis);
  // A diagnosis knows the robot, not the table: what this cell cannot measure is left out, and said.
  const person = form.elements.person.value.trim();
  const body = { person, configurations, diagnosis_id, leave_out_unfit: true };
  // One key a diagnosis: two taps must not send the robot there twice.
  const added = await post(`${session}/configurations`, body, form.dataset.key);
  const left = added.left_out.map((entry) => filled(bar.dataset.leftOut, entry));
  say([added.sentence, ...left, added.session.prompt?.message].filter(Boolean).join(" "));
}

async function diagnose(again) {
  say(bar.dataset.asked);
  const { diagnosing, unreachable } = bar.dataset;
  const told = ({ fraction, message }) => say(filled(diagnosing, { percent: Math.round(100 * fraction), message }));
  const job = await followed(await post(`${session}/diagnosis`, JSON.parse(again.dataset.again)), unreachable, told, say);
  if (job.state !== "succeeded") throw new Error(job.message);
  location.assign(`/diagnoses/${job.result_id}`);
}

form?.addEventListener("submit", (event) => {
  event.preventDefault();
  busy(measure);
});
for (const again of agains) again.addEventListener("click", () => busy(() => diagnose(again)));
