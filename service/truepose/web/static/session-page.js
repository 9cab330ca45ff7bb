// A session under way: where it stands, what it asks, and the acts of a named person.

import { answered, filled, post } from "./api.js";
import { Authority } from "./authority.js";
import { refusal } from "./person.js";
import { now_s } from "./service-time.js";

const POLL_MS = 1000;
const REASON_MISSING = "TP-2006";
const ENDED = ["finished", "aborted", "failed"];
const at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
const { path, unreachable, measured } = at.session.dataset;
const states = JSON.parse(at.session.dataset.states);
const form = at.acts.querySelector("form");
const said = at.acts.querySelector("output");
const person = form.elements.person;
let shown = null;

person.value = sessionStorage.getItem("person") ?? person.value;

function write(node, text) {
  node.hidden = !text;
  if (node.textContent !== (text ?? "")) node.textContent = text ?? "";
}

function show(session) {
  shown = session;
  at.session.dataset.state = session.state;
  at.state.textContent = states[session.state];
  at.measured.textContent = filled(measured, session);
  at.progress.max = Math.max(session.planned, 1);
  at.progress.value = session.measured;
  const question = session.trouble ?? session.prompt?.message;
  write(at.reason, session.reason === question ? null : session.reason);
  write(at.question, question);
  write(at.notice, question ? session.motion_notice : null);
  at.foreign.hidden = !session.tracker_in_question;
  at.acts.hidden = ENDED.includes(session.state);
  for (const button of form.querySelectorAll("[data-act]")) {
    button.hidden = !button.dataset.in.split(" ").includes(session.state);
  }
}

function say(sentence, bad = false) {
  said.textContent = sentence;
  said.classList.toggle("bad", bad);
}

function bodyOf(command) {
  const name = person.value.trim();
  if (["pause", "abort"].includes(command)) return name ? { command, person: name } : { command };
  // Whoever accepts another tracker says which: the number is typed, not offered.
  const serial = at.foreign.hidden ? "" : form.elements.serial.value.trim();
  const reason = form.elements.reason.value.trim();
  const accepted = command === "confirm" && serial && { accept_serial_number: serial };
  return { command, person: name, prompt_id: shown?.prompt?.id, pressed_at_s: now_s(), ...(reason && { reason }), ...accepted };
}

// A ballbar that may be attached and was not seen to come off: a person says how they know that it is off.
function askHowOff(asked) {
  at.off.hidden = !asked;
  if (asked) form.elements.reason.focus();
  else form.elements.reason.value = "";
}

async function act(name) {
  sessionStorage.setItem("person", person.value.trim());
  if (["start", "confirm", "resume"].includes(name) && !person.value.trim()) return person.focus();
  try {
    const answer = await post(`${path}/commands`, bodyOf(name), unreachable);
    say(answer.session.prompt ? "" : answer.sentence); // a question says more
    askHowOff(false);
    show(await answered(path, {}, unreachable));
  } catch (error) {
    if (error.code === REASON_MISSING) askHowOff(true);
    say(error.message, true);
  }
  return undefined;
}

async function look() {
  try {
    show(await answered(path, {}, unreachable));
    if (said.textContent === unreachable) say("");
  } catch (error) {
    say(error.message, true);
  }
  if (!ENDED.includes(shown?.state)) setTimeout(look, POLL_MS);
}

// Somebody else acts: everything can be seen here, and nothing pressed but what halts, before somebody takes over.
function follow(place) {
  const authority = new Authority(path.split("/").at(-1), ({ person: who, mine, tablet }) => {
    place.hidden = !who || mine;
    place.firstElementChild.textContent = filled(at.acts.dataset.acting, { who: tablet ? `${who}, ${tablet}` : who });
  });
  place.querySelector("button").addEventListener("click", async () => {
    const [taken, problem] = await authority.takeOver();
    if (!taken) say((await refusal(problem, "POST")).sentence || unreachable, true);
  });
  authority.keep();
}

if (at.authority) follow(at.authority);
form.addEventListener("submit", (event) => event.preventDefault());
form.addEventListener("click", (event) => {
  const button = event.target.closest("[data-act]");
  if (button) act(button.dataset.act);
});
at.acts.inert = false; // nothing can be tapped before somebody listens
look();
