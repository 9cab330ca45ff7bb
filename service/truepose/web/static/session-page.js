// A session under way: where it stands, what it asks, and the acts of a named person.

import { answered, filled, post } from "./api.js";
import { Authority } from "./authority.js";
import { refusal } from "./person.js";
import { Stored } from "./stored.js";
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

const stored = await Stored.load(document.documentElement.lang);

// A sentence of the service, in the language of the page as far as it is known.
function write(node, text) {
  const kept = text ?? "";
  node.hidden = !kept;
  if (node.dataset.kept === kept) return;
  node.dataset.kept = kept;
  node.replaceChildren(...stored.pieces(kept).flatMap((piece) => [Object.assign(document.createElement("span"), { textContent: piece.text, lang: piece.lang }), " "]));
}

function show(session) {
  shown = session;
  at.session.dataset.state = session.state;
  at.state.textContent = states[session.state];
  at.measured.textContent = filled(measured, session);
  at.progress.max = Math.max(session.planned, 1);
  at.progress.value = session.measured;
  const reason = session.trouble ?? session.reason;
  write(at.reason, reason === session.question ? null : reason);
  write(at.question, session.question);
  write(at.notice, session.question ? session.motion_notice : null);
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

function bodyOf(act) {
  const name = person.value.trim();
  if (act === "start") return {};
  if (["pause", "abort"].includes(act)) return name ? { person: name } : {};
  // Whoever accepts another tracker says which: the number is typed, not offered.
  const serial = at.foreign.hidden ? "" : form.elements.serial.value.trim();
  const reason = form.elements.reason.value.trim();
  return { person: name, prompt_id: shown.prompt_id, pressed_at_s: now_s(), ...(reason && { reason }), ...(act === "confirm" && serial && { accept_serial_number: serial }) };
}

// A ballbar that may be attached and was not seen to come off: a person says how they know that it is off.
function askHowOff(asked) {
  at.off.hidden = !asked;
  if (asked) form.elements.reason.focus();
  else form.elements.reason.value = "";
}

async function act(name) {
  sessionStorage.setItem("person", person.value.trim());
  if (["confirm", "resume"].includes(name) && !person.value.trim()) return person.focus();
  try {
    const answer = await post(`${path}/${name}`, bodyOf(name), unreachable);
    say(answer.session.question ? "" : answer.sentence); // a question says more
    askHowOff(false);
    show(answer.session);
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
