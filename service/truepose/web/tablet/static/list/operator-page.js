// The list of sessions, and the start of a new one.

import { Refused, answerTo, ask, made } from "../common/api.js";
import { element, showIf, write } from "../common/elements.js";
import { Storage, newKey } from "../common/tablet.js";
import { Texts } from "../common/texts.js";

const AGAIN_MS = 2000;
const PAGE = 100;
const SECOND_MS = 1000;
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
  #planning = null; // what is being planned: { name, began_ms, known } (`known`: sessions of before, if they were read)
  #silent = false; // the sentence on the screen says that the service does not answer

  constructor(texts) {
    this.texts = texts;
  }

  open() {
    this.#furnish();
    this.#translate();
    this.#list();
    setInterval(() => document.hidden || this.#list(), AGAIN_MS);
    answerTo(() => ask("/api/v1/simulated-hands")).then((found) => showIf(this.#at.simulated, found?.simulated === true), () => null);
  }

  #furnish() {
    for (const place of document.querySelectorAll(".choices")) this.#choices(place);
    this.#at.language.addEventListener("change", () => this.texts.choose(this.#at.language.value).then(() => this.#translate()));
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
    if (this.#planning) this.#showPlanning();
    if (this.#listed) this.#show(this.#listed);
  }

  #estimate() {
    if (this.#planning) return;
    const readings = readingsOf(this.#chosen);
    write(this.#at.estimate, this.texts.say("new.estimate", { readings, time: this.texts.duration(readings * PACE_S) }));
  }

  async #plan() {
    const form = this.#at.new;
    const name = form.elements.name.value.trim();
    if (!name) return form.elements.name.focus();
    this.#planning = { name, began_ms: performance.now(), known: this.#listed?.map((session) => session.id) };
    const ticking = setInterval(() => this.#showPlanning(), SECOND_MS);
    this.#showPlanning();
    try {
      this.#open(await this.#planned({ name, ...this.#chosen }));
    } catch (refused) {
      // A refusal is an answer: the next wish is another one.
      this.#key = newKey();
      this.#say(refused.message || this.texts.say("queue.failed", { status: refused.status }));
    } finally {
      clearInterval(ticking);
      this.#planning = null;
      this.#showForm();
    }
    return undefined;
  }

  // However long it takes, and whatever becomes of the connection: the key makes a second arrival harmless.
  #planned(wish) {
    return answerTo(() => made("/api/v1/sessions", { kind: "ballbar", ...wish }, this.#key));
  }

  // The answer may be lost on its way while the session is stored: the list shows it.
  #findPlanned(sessions) {
    const { name, known } = this.#planning;
    const found = known && sessions.find((session) => session.name === name && !known.includes(session.id));
    if (found) this.#open(found.id);
  }

  #open(id) {
    location.assign(`/operator/${id}`);
  }

  #showPlanning() {
    const seconds = Math.floor((performance.now() - this.#planning.began_ms) / SECOND_MS);
    const time = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
    this.#showForm();
    write(this.#at.plan, this.texts.say("new.planning", { time }));
    write(this.#at.estimate, this.texts.say("new.patience"));
  }

  // What is planned stays as it was wished.
  #showForm() {
    const planning = this.#planning !== null;
    this.#at.wish.disabled = planning;
    this.#at.plan.classList.toggle("at-work", planning);
    if (planning) return;
    write(this.#at.plan, this.texts.say("new.plan"));
    this.#estimate();
  }

  async #list() {
    try {
      const sessions = await this.#sessions();
      this.#show(sessions);
      if (this.#planning) this.#findPlanned(sessions);
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
    return found.reverse();
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
    const { measured, planned } = session;
    return element("li", { "data-state": session.state },
      element("a", { href: `/operator/${session.id}` },
        element("b", {}, session.name),
        element("span", { class: "state" }, this.texts.say(STATES[session.state])),
        element("span", { class: "amount" }, this.texts.say("list.poses", { measured, planned })),
        element("span", { class: "open" }, this.texts.say("list.open"))));
  }

  #say(sentence) {
    write(this.#at.said, sentence);
    showIf(this.#at.said, true);
  }
}

new OperatorPage(await Texts.load(new Storage())).open();
