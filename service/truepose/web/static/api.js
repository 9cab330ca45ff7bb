// What the pages ask of the API: whatever it refuses is said in its own sentence.

import { refusal } from "./person.js";
import { hear } from "./service-time.js";
import { inItsWords } from "./words.js";

const NOTHING = 204;
const BUSY = 503;
const POLL_MS = 500;
const UNDER_WAY = ["queued", "running"];

// Nobody has answered, or with "not now": it says nothing of what was asked.
export class Unanswered extends Error {}

// A page of something between here and the service is no answer either.
async function said(path, request) {
  const reply = hear(await fetch(path, inItsWords(request)));
  return [reply, reply.status === NOTHING ? null : await reply.json()];
}

export async function answered(path, request, unreachable) {
  const [reply, answer] = await said(path, request).catch(() => [null, null]);
  if (reply === null) throw new Unanswered(unreachable);
  if (reply.status === BUSY) throw new Unanswered(answer.detail ?? unreachable);
  if (!reply.ok) throw Object.assign(new Error((await refusal(answer, request.method)).sentence), { code: answer.code });
  return answer;
}

// Asks until somebody has answered; `heard(sentence)` is told why nobody has.
export async function answerTo(ask, heard = () => null) {
  for (;;) {
    try {
      return await ask();
    } catch (error) {
      if (!(error instanceof Unanswered)) throw error;
      heard(error.message);
    }
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
}

// Follows a job to its end, which does not depend on who can be asked meanwhile; `told(job)` hears how far it is.
export async function followed(job, unreachable, told, say) {
  while (UNDER_WAY.includes(job.state)) {
    told(job);
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    job = await answerTo(() => answered(`/api/v1/jobs/${job.id}`, {}, unreachable), say);
  }
  return job;
}

export function post(path, body, unreachable, key) {
  const headers = { "Content-Type": "application/json", Prefer: "respond-async" };
  if (key) headers["Idempotency-Key"] = key;
  return answered(path, { method: "POST", headers, body: JSON.stringify(body) }, unreachable);
}

// A page's text has its blanks in angle brackets: braces are filled in before it is sent.
export function filled(text, values) {
  return text.replace(/<(\w+)>/g, (_, name) => values[name]);
}

// Has something done for a form: `act` says how far it is, what it throws is shown, and nobody sends it twice meanwhile.
export async function sayingIn(form, act) {
  const said = form.querySelector("output");
  const button = form.querySelector("button");
  const say = (sentence, bad = false) => {
    said.textContent = sentence;
    said.classList.toggle("bad", bad);
  };
  button.disabled = true;
  form.ariaBusy = "true";
  try {
    await act(say);
  } catch (error) {
    say(error.message, true);
  } finally {
    button.disabled = false;
    form.ariaBusy = null;
  }
}

export function onSubmit(form, act) {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    sayingIn(form, act);
  });
}
