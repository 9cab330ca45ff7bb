// The forms of signing in, of choosing a password, of people and of programs.

import { answered, filled, onSubmit } from "./api.js";
import { inPage } from "./page-part.js";
import { ours } from "./person.js";
import { holdControls } from "./shell.js";

const form = (id) => document.getElementById(id);

function sent(from, path, body, method = "POST") {
  const headers = { "Content-Type": "application/json" };
  return answered(path, { method, headers, body: JSON.stringify(body) }, from.dataset.unreachable);
}

// What a form says; what was left empty is not said.
const said = (from, ...names) => Object.fromEntries(names.map((name) => [name, from.elements[name]?.value]).filter(([, value]) => value));

function leave() {
  location.replace(ours(new URLSearchParams(location.search).get("next") ?? "/"));
}

function signIn(here) {
  // A link from elsewhere brings no cookie; whoever is signed in goes on at once.
  fetch("/api/v1/sign-ins/present", { cache: "no-store" }).then((reply) => (reply.ok ? reply.json() : Promise.reject(reply))).then((who) => who.accounts !== "on" || who.name ? leave() : null, () => null);
  onSubmit(here, async () => {
    await sent(here, "/api/v1/sign-ins", said(here, "name", "password", "tablet"));
    leave();
  });
}

function choose(here, path, names) {
  const secret = location.pathname.split("/").at(-1);
  onSubmit(here, async () => {
    if (here.elements.password.value !== here.elements.repeated.value) throw new Error(here.dataset.differ);
    await sent(here, path, { secret, ...said(here, ...names) });
    location.replace("/");
  });
}

function account(here) {
  onSubmit(here, async (say) => {
    await sent(here, "/api/v1/sign-ins/present/secrets", said(here, "present_password", "password", "pin", "badge"), "PUT");
    here.reset();
    say(here.dataset.done);
  });
}

const linkOf = (entered) => new URL(entered.link, location.origin).href;

function enter(here) {
  onSubmit(here, async (say) => {
    const entered = await sent(here, "/api/v1/people", said(here, "name", "role"));
    say(filled(here.dataset.link, { name: entered.person.name, link: linkOf(entered) }));
    here.reset();
    await Promise.all([inPage("#listed"), inPage("#owner")]);
    const listed = document.querySelector("#listed");
    holdControls(listed);
    changes(listed);
  });
}

function token(here) {
  onSubmit(here, async (say) => {
    const hours = Number(here.elements.hours.value);
    const made = await sent(here, "/api/v1/tokens", { ...said(here, "name", "owner", "role"), hours });
    say(filled(here.dataset.token, { secret: made.secret }));
  });
}

const CHANGES = {
  role: (row, control) => [`/api/v1/people/${row.dataset.personId}/role`, "PUT", { role: control.value }],
  link: (row) => [`/api/v1/people/${row.dataset.personId}/link`, "POST"],
  remove: (row) => [`/api/v1/people/${row.dataset.personId}`, "DELETE"],
  revoke: (row) => [`/api/v1/tokens/${row.dataset.tokenId}`, "DELETE"],
};

async function change(control) {
  const [path, method, body] = CHANGES[control.dataset.change](control.closest("tr"), control);
  const request = { method, ...(body && { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }) };
  const { unreachable, link } = form("enter").dataset;
  const told = form("told");
  try {
    const answer = await answered(path, request, unreachable);
    if (control.dataset.change === "link") told.textContent = filled(link, { name: answer.person.name, link: linkOf(answer) });
    else location.reload();
  } catch (error) {
    told.textContent = error.message;
  }
}

function changes(root) {
  for (const control of root.querySelectorAll("[data-change]")) {
    control.addEventListener(control.matches("select") ? "change" : "click", () => change(control));
  }
}

const FORMS = {
  "sign-in": signIn,
  first: (here) => choose(here, "/api/v1/first-person", ["name", "password", "pin"]),
  welcome: (here) => choose(here, "/api/v1/links/accepted", ["password", "pin"]),
  account,
  enter,
  token,
};
for (const [id, begin] of Object.entries(FORMS)) if (form(id)) begin(form(id));
changes(document);
