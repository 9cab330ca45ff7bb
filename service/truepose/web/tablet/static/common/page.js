// What the page of every kind of session does alike: its taps, its connection, its language, whose hands act.

import { ask, answerTo } from "./api.js";
import { signedInAs, switchPerson } from "/static/person.js";
import { Authority } from "/static/authority.js";
import { showIf, write } from "./elements.js";
import { Live } from "./live.js";
import { isTaken } from "./people.js";
import { Queue } from "./queue.js";
import { Sender } from "./sender.js";
import { stepOf } from "./situation.js";
import { Sound } from "./sound.js";
import { Tablet } from "./tablet.js";
import { stayAwake } from "./wake.js";

const SAID_MS = 9000; // a sentence of the service stays so long
const NOT_FOUND = 404;
const ONLY_OFF = ["confirm", "resume"]; // they need a reason where a ballbar may be attached
const ACTS = {
  start: "act.start", confirm: "act.done", store: "act.store", answer: "act.answer", hand_over: "act.hand_over",
  resume: "dock.resume", back: "dock.back", retry: "dock.retry", skip: "dock.skip", pause: "dock.pause",
  abort: "dock.abort", stop: "dock.stop",
};

// A key that stays down is one tap, whatever screens come by meanwhile.
function oneTapAKey(event) {
  if (event.repeat && [" ", "Enter"].includes(event.key) && event.target.closest("button")) event.preventDefault();
}

// A kind of session adds `show()`, `taken(before, session)`, `sampled(sample)`, `reload()` and `stepInWords(id)`,
// and what it needs of `furnish()`, `unlinked()` and `seen(act)`: what the person saw who lets the session go on.
export class Page {
  at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
  #drawing = false;
  #saying = null;

  constructor(texts, storage, { path, live = `${path}/live`, onlyNow }) {
    const id = document.body.dataset.session;
    this.path = path;
    this.texts = texts;
    this.tablet = new Tablet(storage);
    if (signedInAs) this.tablet.person = signedInAs;
    this.model = {
      session: null, sample: null, up: false, opened: false, missing: false, tablet: this.tablet, queue: new Queue(storage, id), onlyNow,
    };
    this.sound = new Sound(() => this.tablet.muted);
    this.sender = new Sender(path, this.model.queue, {
      changed: () => this.draw(),
      answered: (session) => this.accept(session),
      dropped: (tap, error) => this.#dropped(tap, error),
      unreached: (tap) => this.say(this.texts.say(tap.act === "confirm" ? "lost.motion" : "lost.only_now")),
    });
    this.live = new Live(`${live}?tablet=${encodeURIComponent(this.tablet.id)}`, {
      state: (up) => this.#linked(up),
      sample: (sample) => this.sampled(sample),
      situation: (session) => this.accept(session),
    });
    this.#listen();
  }

  open() {
    this.texts.translate(document);
    this.draw();
    this.live.open();
    stayAwake(() => this.live.restart());
    this.refresh().catch((error) => this.#missing(error));
    // Whoever is signed in has the authority as long as this page is open.
    if (signedInAs) new Authority(document.body.dataset.session, () => null).keep();
  }

  #listen() {
    const at = this.at;
    document.addEventListener("keydown", oneTapAKey);
    at.language.addEventListener("change", () => this.#speak(at.language.value));
    at.units.addEventListener("click", () => (this.texts.units.switch(), this.#inOtherWords()));
    at.mute.addEventListener("click", () => ((this.tablet.muted = !this.tablet.muted), this.draw()));
    at.person.addEventListener("click", () => this.askName());
    at["take-over"].addEventListener("click", () => this.dialogues.takeOver(this.model.session.acting?.person, () => this.act("hand_over")));
    at.said.addEventListener("click", () => showIf(at.said, false));
  }

  // Everything is drawn once a frame at most, whatever changed.
  draw() {
    if (this.#drawing) return;
    this.#drawing = true;
    requestAnimationFrame(() => {
      this.#drawing = false;
      this.show();
    });
  }

  // Takes what the service says of the session, unless something newer is known.
  accept(session) {
    const before = this.model.session;
    if (before && (session.ledger_number ?? 0) < (before.ledger_number ?? 0)) return;
    this.model.session = session;
    if (!before && !isTaken(this.tablet.person, session.people)) this.askName();
    this.taken(before, session);
    this.draw();
  }

  async refresh() {
    this.accept(await answerTo(() => ask(`${this.path}/situation`)));
    await this.reload();
  }

  // A tap: kept until it is answered, or, where it sets something going, sent now or never.
  act(act, more = {}) {
    const { session, onlyNow } = this.model;
    // Nobody has to say a name in danger.
    const person = this.tablet.person ?? (act === "stop" ? this.texts.record("name.none") : null);
    const tap = { act, step_id: stepOf(session, act), person, tablet: this.tablet.id, ...more };
    if (!tap.person) return this.askName();
    if (onlyNow(session, act)) return this.sender.now({ ...tap, ...this.seen(act) });
    if (!this.sender.queue(tap)) this.say(this.texts.say("queue.full"));
    if (act === "stop" && !this.model.up) this.say(this.texts.say("lost.stop"));
    return undefined;
  }

  seen() {
    return {};
  }

  say(sentence) {
    const { said } = this.at;
    write(said, sentence);
    showIf(said, true);
    clearTimeout(this.#saying);
    this.#saying = setTimeout(() => showIf(said, false), SAID_MS);
  }

  speak(text) {
    write(this.at.spoken, text);
  }

  // `refused`: what the service said of the name that is kept.
  askName(refused = "") {
    if (signedInAs) return this.#switchPerson();
    const people = this.model.session?.people ?? [];
    this.dialogues.name({ present: this.tablet.person, people, refused }, (name) => {
      this.tablet.person = name;
      this.draw();
    });
    return undefined;
  }

  async #switchPerson() {
    const who = await switchPerson().catch((error) => this.say(error.message));
    if (!who) return;
    this.tablet.person = who.name;
    this.draw();
  }

  async #speak(language) {
    await this.texts.choose(language);
    this.texts.translate(document);
    this.#inOtherWords();
  }

  // What the service says comes in the new ones with its next word.
  #inOtherWords() {
    this.dialogues.again();
    this.draw();
    this.live.inOtherWords();
    if (this.model.up) this.refresh().catch(() => null); // else as soon as there is a link
  }

  #linked(up) {
    this.model.up = up;
    if (!up && this.model.opened) this.sound.play("lost");
    this.model.opened ||= up;
    if (!up) this.model.sample = null;
    if (up) this.refresh().then(() => this.sender.flush(), () => this.sender.flush());
    this.draw();
  }

  async #dropped(tap, error) {
    await this.refresh().catch(() => null);
    if (error.ofName) return this.askName(error.message);
    if (error.ofReason && ONLY_OFF.includes(tap.act)) return this.dialogues.off((reason) => this.act(tap.act, { reason }));
    if (error.solved) return this.say(error.message);
    const name = this.texts.say(ACTS[tap.act]);
    const gone = tap.step_id !== null && this.isGone(tap);
    if (gone) return this.say(this.texts.say("queue.dropped", { tap: name, step: this.stepInWords(tap.step_id) }));
    const reason = error.message || this.texts.say("queue.failed", { status: error.status });
    return this.say(this.texts.say("queue.refused", { tap: name, reason }));
  }

  isGone(tap) {
    return tap.step_id !== this.model.session?.step?.id;
  }

  #missing(error) {
    this.model.missing = error.status === NOT_FOUND;
    this.say(error.message || this.texts.say("queue.failed", { status: error.status }));
    this.draw();
  }
}
