// Who stands before this browser: somebody else by PIN or badge, the same person once more, or nobody.

import { inItsWords } from "./words.js";

const PRESENT = "/api/v1/sign-ins/present";
const PROBLEM = "urn:truepose:problem:";
const template = document.querySelector("#person-dialogue");
export const signedInAs = template?.dataset.name || null; // null: nobody is asked who they are

async function sent(path, method, body) {
  const request = { method, cache: "no-store", headers: { "Content-Type": "application/json" } };
  if (body) request.body = JSON.stringify(body);
  const reply = await fetch(path, inItsWords(request)).catch(() => null);
  if (reply === null) throw new Error(template.dataset.unreachable);
  const answer = reply.status === 204 ? null : await reply.json();
  if (!reply.ok) throw new Error(answer.detail);
  return answer;
}

// One question at a time: who it is, and their PIN. Resolves with who is signed in then; null where nobody answered.
class Dialogue {
  #dialog = template.content.firstElementChild.cloneNode(true);
  #pin = this.#dialog.querySelector(".pin");
  #who;
  #proof;
  #answer = null;

  // `proof`: "pin" (or the password in its place), or "password" alone.
  constructor(title, path, { who = {}, proof = "pin" } = {}) {
    this.path = path;
    this.#who = who;
    this.#proof = proof;
    const heading = this.#dialog.querySelector("h2");
    heading.textContent = heading.dataset[title];
    document.body.append(this.#dialog);
    this.#dialog.addEventListener("keydown", (event) => {
      // A reader types the badge and presses Enter, as a person does behind a PIN.
      if (event.key === "Enter" && event.target.matches("input")) this.#submit();
    });
    this.#dialog.querySelector(".leave").addEventListener("click", () => this.#dialog.close());
    for (const key of this.#dialog.querySelectorAll("[data-key]")) key.addEventListener("click", () => this.#type(key.dataset.key));
  }

  // `people`: whom to choose from; none: whoever is signed in.
  ask(people) {
    const [badge, pin] = [this.#field("badge"), this.#field("pin")];
    badge.closest("label").hidden = !people;
    this.#dialog.querySelector(".instead").hidden = Boolean(people);
    this.#dialog.querySelector(".names").replaceChildren(...(people ?? []).map((name) => this.#name(name)));
    if (!people) this.#askPin(this.#who.name ?? "");
    if (this.#proof === "password") this.#askPasswordAlone();
    this.#dialog.showModal();
    (people ? badge : this.#field(this.#proof)).focus();
    return new Promise((resolve) => {
      this.#dialog.addEventListener("close", () => (this.#dialog.remove(), resolve(this.#answer)));
    });
  }

  #askPasswordAlone() {
    for (const key of this.#dialog.querySelectorAll("[data-key]")) key.hidden = key.dataset.key !== "ok";
    this.#field("pin").closest("label").hidden = true;
    const said = this.#dialog.querySelector(".instead span");
    said.textContent = said.dataset.alone;
  }

  #field(name) {
    return this.#dialog.querySelector(`[name=${name}]`);
  }

  #name(name) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "main", textContent: name });
    button.addEventListener("click", () => ((this.#who = { name }), this.#askPin(name)));
    return button;
  }

  #askPin(name) {
    this.#dialog.querySelector(".names").replaceChildren();
    this.#field("badge").closest("label").hidden = true;
    this.#dialog.querySelector(".chosen").textContent = name;
    this.#pin.hidden = false;
    this.#field(this.#proof).focus();
  }

  #type(key) {
    const pin = this.#field("pin");
    if (key === "ok") return this.#submit();
    pin.value = key === "back" ? pin.value.slice(0, -1) : pin.value + key;
    return undefined;
  }

  async #submit() {
    const [badge, pin, password] = ["badge", "pin", "password"].map((name) => this.#field(name));
    if (this.#pin.hidden) return badge.value ? ((this.#who = { badge: badge.value }), this.#askPin("")) : undefined;
    const said = this.#dialog.querySelector("output");
    try {
      const shown = password.value ? { password: password.value } : { pin: pin.value };
      this.#answer = await sent(this.path, "POST", { ...this.#who, ...shown });
      this.#dialog.close();
    } catch (error) {
      said.textContent = error.message;
      pin.value = password.value = "";
    }
    return undefined;
  }
}

// Says whether whoever is signed in has shown once more that it is them.
const showAgain = () => new Dialogue("again", `${PRESENT}/fresh`).ask(null);

export async function switchPerson() {
  const { people } = await sent(PRESENT, "GET");
  return new Dialogue("switch", `${PRESENT}/person`).ask(people);
}

// A sign-in that has ended is begun again in place: what stands on the page stays.
const signInAgain = () => new Dialogue("ended", "/api/v1/sign-ins", { who: { name: signedInAs }, proof: "password" }).ask(null);

const SOLVED = { "fresh-sign-in": [showAgain, "once"], "sign-in": [signInAgain, "back"] };
let asking = null; // one question at a time, however many requests were refused

// What is said of a refusal: where it asks who it is, that is asked first. Nothing is repeated by itself: afterwards
// a person presses once more, which is the second confirmation. `solved`: they may, at once. What a page looks at by
// itself asks nobody.
export async function refusal(problem, method = "GET") {
  const [ask, then] = SOLVED[problem?.type?.replace(PROBLEM, "")] ?? [];
  if (!ask || !signedInAs || method === "GET") return { sentence: problem?.detail ?? "", solved: false };
  asking ??= ask().finally(() => (asking = null));
  const solved = Boolean(await asking);
  return { sentence: solved ? template.dataset[then] : problem.detail, solved };
}

// Whoever is signed in need not say their name: the service takes no other.
if (signedInAs) {
  sessionStorage.setItem("person", signedInAs);
  for (const field of document.querySelectorAll("[name=person]")) {
    if (field.options) field.add(new Option(signedInAs));
    field.value = signedInAs;
    field.closest("label").hidden = true;
  }
}

// An address of this service; any other leads to its first page.
export function ours(address) {
  const wanted = new URL(address, location.origin);
  return wanted.origin === location.origin ? wanted : new URL("/", location.origin);
}

for (const button of document.querySelectorAll("[data-person]")) {
  button.addEventListener("click", async () => {
    const leaves = button.dataset.person === "out";
    try {
      if (!(leaves ? await sent(PRESENT, "DELETE").then(() => true) : await switchPerson())) return;
      location.assign(leaves ? "/sign-in" : ours(button.dataset.then ?? location.href));
    } catch {
      document.querySelector("[data-lost]").hidden = false; // whoever was signed in still is
    }
  });
}
