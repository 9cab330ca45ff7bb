// The list of sessions, and the start of a new one.

import { Refused, ask, post } from "./api.js";
import { element, showIf, write } from "./elements.js";
import { Storage, newKey } from "./tablet.js";
import { Texts } from "./texts.js";

const AGAIN_MS = 2000;
const PAGE = 100;
const PLANNING_MS = 120_000;
const PACE_S = 9.5; // a reading, as the thesis took them: six legs and a motion a minute
const STATES = {
  planned: "session.planned",
  running: "session.running",
  pausing: "session.pausing",
  paused: "session.paused",
  awaiting_confirmation: "session.awaiting_confirmation",
  aborted: "session.aborted",
  finished: "session.finished",
  failed: "session.failed",
};

// Readings of a whole session: triangles with their initialisation, then a zero and six legs a pose.
export function readingsOf({ placement_count, base_points, poses }) {
  const sides = base_points === 3 ? 3 : 6;
  return 4 + placement_count * (1 + sides + 7 * poses);
}

class OperatorPage {
  #at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
  #chosen = {};
  #key = newKey();
  #listed = null;
  #silent = false; // the sentence on the screen says that the service does not answer

  constructor(texts) {
    this.texts = texts;
  }

  open() {
    this.#furnish();
    this.#translate();
    this.#list();
    setInterval(() => document.hidden || this.#list(), AGAIN_MS);
    ask("/api/v1/simulated-hands").then((found) => showIf(this.#at.simulated, found?.simulated === true), () => null);
  }

  #furnish() {
    for (const place of document.querySelectorAll(".choices")) this.#choices(place);
    this.#at.language.addEventListener("click", () => (this.texts.switchLanguage(), this.#translate()));
    this.#at.new.addEventListener("submit", (event) => (event.preventDefault(), this.#plan()));
  }

  #choices(place) {
    const { name, values, chosen } = place.dataset;
    this.#chosen[name] = Number(chosen);
    const choose = (value) => ((this.#chosen[name] = Number(value)), this.#estimate());
    const choice = (value) =>
      element("label", { class: "choice" },
        element("input", { type: "radio", name, value, checked: value === chosen, onchange: () => choose(value) }),
        element("span", {}, value));
    place.append(...values.split(" ").map(choice));
  }

  #translate() {
    this.texts.translate(document);
    this.#estimate();
    if (this.#listed) this.#show(this.#listed);
  }

  #estimate() {
    const readings = readingsOf(this.#chosen);
    write(this.#at.estimate, this.texts.say("new.estimate", { readings, time: this.texts.duration(readings * PACE_S) }));
  }

  async #plan() {
    const form = this.#at.new;
    const name = form.elements.name.value.trim();
    if (!name) return form.elements.name.focus();
    const button = form.querySelector("button");
    button.disabled = true;
    write(button, this.texts.say("new.planning"));
    try {
      const session = await post("/api/v1/ballbar-sessions", { name, ...this.#chosen }, this.#key, PLANNING_MS);
      return location.assign(`/operator/${session.id}`);
    } catch (error) {
      this.#say(error instanceof Refused && error.message ? error.message : this.texts.say("list.unreached"));
      // A refusal is an answer: the next wish is another one.
      if (error instanceof Refused) this.#key = newKey();
      return undefined;
    } finally {
      button.disabled = false;
      write(button, this.texts.say("new.plan"));
    }
  }

  async #list() {
    try {
      this.#show(await this.#sessions());
      if (this.#silent) showIf(this.#at.said, false);
      this.#silent = false;
    } catch {
      this.#silent = true;
      this.#say(this.texts.say("list.unreached"));
    }
  }

  // The API lists oldest first, a page at a time.
  async #sessions() {
    const found = [];
    let page;
    do {
      const after = found.at(-1)?.id ?? 0;
      page = await ask(`/api/v1/sessions?after=${after}&limit=${PAGE}`);
      found.push(...page);
    } while (page.length === PAGE);
    return found.filter((session) => session.role === "ballbar").reverse();
  }

  #show(sessions) {
    const shown = JSON.stringify([sessions, this.texts.language]);
    if (shown === this.#at.sessions.dataset.shown) return;
    this.#listed = sessions;
    this.#at.sessions.dataset.shown = shown;
    this.#at.sessions.replaceChildren(...sessions.map((session) => this.#row(session)));
    showIf(this.#at.none, sessions.length === 0);
  }

  #row(session) {
    const { measured: readings, planned } = session;
    return element("li", { "data-state": session.state },
      element("a", { href: `/operator/${session.id}` },
        element("b", {}, session.name),
        element("span", { class: "state" }, this.texts.say(STATES[session.state])),
        element("span", { class: "amount" }, this.texts.say("list.readings", { readings, planned })),
        element("span", { class: "open" }, this.texts.say("list.open"))));
  }

  #say(sentence) {
    write(this.#at.said, sentence);
    showIf(this.#at.said, true);
  }
}

new OperatorPage(await Texts.load(new Storage())).open();
