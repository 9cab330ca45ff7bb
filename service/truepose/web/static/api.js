// What the pages ask of the API: whatever it refuses is said in its own sentence.

import { refusal } from "./person.js";

const NOTHING = 204;

export async function answered(path, request, unreachable) {
  let reply;
  try {
    reply = await fetch(path, request);
  } catch {
    throw new Error(unreachable);
  }
  const answer = reply.status === NOTHING ? null : await reply.json();
  if (!reply.ok) throw new Error(await refusal(answer));
  return answer;
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
