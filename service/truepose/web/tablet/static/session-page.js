// One session, a step a screen: everything is joined here.

import { Actions } from "./actions.js";
import { Refused, ask } from "./api.js";
import { Caution } from "./caution.js";
import { Connection } from "./connection.js";
import { Dialogues } from "./dialogues.js";
import { Dock } from "./dock.js";
import { showIf, write } from "./elements.js";
import { Gauge } from "./gauge.js";
import { Hands } from "./hands.js";
import { Live } from "./live.js";
import { isTaken } from "./people.js";
import { Queue } from "./queue.js";
import { Sender } from "./sender.js";
import { READ, hasEnded, onlyNow, screenOf, seen, stepOf, takesReason } from "./situation.js";
import { Sound } from "./sound.js";
import { Stage } from "./stage.js";
import { Storage, Tablet } from "./tablet.js";
import { Texts } from "./texts.js";
import { Top } from "./top.js";
import { stayAwake } from "./wake.js";
import { stepInWords } from "./words.js";

const SAID_MS = 9000; // a sentence of the service stays so long
const STORED_MS = 2600;
const SPOKEN_MS = 700; // a state is spoken once it has lasted
const NOT_FOUND = 404;
const ACTS = {
  start: "act.start", confirm: "act.done", store: "act.store", answer: "act.answer", hand_over: "act.hand_over",
  resume: "dock.resume", back: "dock.back", retry: "dock.retry", skip: "dock.skip", pause: "dock.pause",
  abort: "dock.abort", stop: "dock.stop",
};

// An outcome, or a listed step with its outcome, that kept a length.
const measured = (said) => [said?.kind, said?.outcome].includes("measured") && said.length_mm !== null;

// A key that stays down is one tap, whatever screens come by meanwhile.
function oneTapAKey(event) {
  if (event.repeat && [" ", "Enter"].includes(event.key) && event.target.closest("button")) event.preventDefault();
}

class SessionPage {
  #at = Object.fromEntries([...document.querySelectorAll("[id]")].map((node) => [node.id, node]));
  #id = document.body.dataset.session;
  #path = `/api/v1/ballbar-sessions/${this.#id}`;
  #connection = new Connection();
  #drawing = false;
  #handsExist = false;
  #speaking = null;
  #saying = null;

  constructor(texts, storage) {
    this.texts = texts;
    this.tablet = new Tablet(storage);
    this.model = {
      session: null, steps: [], stepsById: new Map(), scene: null, sceneOf: null, sample: null, sampleOf: null,
      up: false, opened: false, missing: false, stored: null, storedNow: false, tablet: this.tablet, queue: new Queue(storage, this.#id),
    };
    this.sound = new Sound(() => this.tablet.muted);
    this.sender = new Sender(this.#id, this.model.queue, {
      changed: () => this.draw(),
      answered: (session) => this.accept(session),
      dropped: (tap, error) => this.#dropped(tap, error),
      unreached: (tap) => this.say(this.texts.say(tap.act === "confirm" ? "lost.motion" : "lost.only_now")),
    });
    this.live = new Live(`${this.#path}/live?tablet=${encodeURIComponent(this.tablet.id)}`, {
      state: (up) => this.#linked(up),
      sample: (sample) => this.#sampled(sample),
      situation: (session) => this.accept(session),
    });
    this.#furnish();
  }

  open() {
    this.texts.translate(document);
    this.draw();
    this.live.open();
    stayAwake(() => this.live.restart());
    this.refresh().catch((error) => this.#missing(error));
    this.hands.exist().then((exist) => ((this.#handsExist = exist), this.draw()));
  }

  #furnish() {
    const at = this.#at;
    this.top = new Top(at);
    this.stage = new Stage(at, () => this.draw());
    this.caution = new Caution(at.caution);
    this.gauge = new Gauge(at, this.texts);
    this.dialogues = new Dialogues(at.dialogue, this.texts);
    this.dock = new Dock(at.dock, (act) => this.#tapped(act));
    this.actions = new Actions(at.actions, { tapped: (act, more) => this.act(act, more), settled: () => this.draw() });
    this.hands = new Hands(at.hands, {
      present: () => this.model.session,
      pairs: () => this.#pairs(),
      other: (chosen) => this.dialogues.pairs(this.#pairs(), chosen),
      failed: (sentence) => this.say(sentence || this.texts.say("hands.unreached")),
    });
    document.addEventListener("keydown", oneTapAKey);
    at.language.addEventListener("click", () => this.#switchLanguage());
    at.mute.addEventListener("click", () => ((this.tablet.muted = !this.tablet.muted), this.draw()));
    at.person.addEventListener("click", () => this.#askName());
    at["take-over"].addEventListener("click", () => this.#takeOver());
    at.said.addEventListener("click", () => showIf(at.said, false));
  }

  // Everything is drawn once a frame at most, whatever changed.
  draw() {
    if (this.#drawing) return;
    this.#drawing = true;
    requestAnimationFrame(() => {
      this.#drawing = false;
      const screen = screenOf(this.model.session, this.model.missing);
      this.top.show(this.model, this.texts);
      this.stage.show(screen, this.model, this.texts);
      this.dock.show(this.model, this.texts);
      this.caution.show(screen, this.model.session, this.texts);
      this.actions.show(screen, this.model, this.texts);
      this.#showLength();
      this.#showSimulated();
    });
  }

  // Takes what the service says of the session, unless something newer is known.
  accept(session) {
    const before = this.model.session;
    if (before && (session.ledger_number ?? 0) < (before.ledger_number ?? 0)) return;
    this.model.session = session;
    if (!before && !isTaken(this.tablet.person, session.people)) this.#askName();
    if (measured(session.last_outcome)) this.model.stored = session.last_outcome;
    if (before) this.#news(before, session);
    else if (session.suspicion) this.#connection.read(session.suspicion.length_mm);
    if (before?.step?.id !== session.step?.id || before?.state !== session.state) this.#newStep(session);
    this.draw();
  }

  async refresh() {
    this.accept(await ask(this.#path));
    await this.#loadSteps();
    await this.#loadScene();
  }

  // A tap: kept until it is answered, or, where it sets something going, sent now or never.
  act(act, more = {}) {
    const { session, sample } = this.model;
    // Nobody has to say a name in danger.
    const person = this.tablet.person ?? (act === "stop" ? this.texts.record("name.none") : null);
    const tap = { act, step_id: stepOf(session, act), person, tablet: this.tablet.id, ...more };
    if (!tap.person) return this.#askName();
    if (!tap.reason && takesReason(session, sample, act)) return this.dialogues.off((reason) => this.act(act, { ...more, reason }));
    if (onlyNow(session, act)) return this.sender.now({ ...tap, ...seen(session, sample, act) });
    if (!this.sender.queue(tap)) this.say(this.texts.say("queue.full"));
    if (act === "retry") this.#connection.renew(); // the service reads at once then
    if (act === "stop" && !this.model.up) this.say(this.texts.say("lost.stop"));
    return undefined;
  }

  say(sentence) {
    const { said } = this.#at;
    write(said, sentence);
    showIf(said, true);
    clearTimeout(this.#saying);
    this.#saying = setTimeout(() => showIf(said, false), SAID_MS);
  }

  #tapped(act) {
    const { session, sample } = this.model;
    if (act === "abort") return this.dialogues.abort(() => this.act("abort"));
    if (act !== "skip") return this.act(act);
    const step = session.step.id;
    const chosen = (reason) => this.act("skip", { reason, step_id: step });
    return this.dialogues.skip(session.step, sample?.state, chosen);
  }

  // `refused`: what the service said of the name that is kept.
  #askName(refused = "") {
    const people = this.model.session?.people ?? [];
    this.dialogues.name({ present: this.tablet.person, people, refused }, (name) => {
      this.tablet.person = name;
      this.draw();
    });
  }

  #takeOver() {
    const { session } = this.model;
    this.dialogues.takeOver(session.acting?.person, () => this.act("hand_over"));
  }

  #pairs() {
    const points = this.model.scene?.points ?? [];
    const numbers = (kind) => points.filter((point) => point.kind === kind).map((point) => Number(point.name.slice(1)));
    return numbers("cup").flatMap((base) => numbers("nest").map((tool) => [base, tool]));
  }

  #switchLanguage() {
    this.texts.switchLanguage();
    this.texts.translate(document);
    this.dialogues.again();
    this.draw();
  }

  // The record says whether it is simulated. Hands are there wherever the service's cell has some: one whose
  // simulated devices are named one by one is no simulated cell to its record.
  #showSimulated() {
    const at = this.#at;
    const simulated = this.model.session?.simulated === true;
    showIf(at.simulated, simulated || this.#handsExist);
    showIf(at["simulated-word"], simulated);
    showIf(at["hands-title"], this.#handsExist);
    showIf(at.hands, this.#handsExist);
    if (this.#handsExist) this.hands.show(this.texts);
  }

  #news(before, session) {
    const told = JSON.stringify(session.last_outcome) !== JSON.stringify(before.last_outcome);
    if (told && measured(session.last_outcome)) this.#stored(session.last_outcome);
    if (!before.suspicion && session.suspicion) this.#doubted(session.suspicion);
    if (before.step?.id !== session.step?.id && session.step?.kind === "move") this.sound.play("move");
  }

  #doubted({ length_mm }) {
    this.sound.play("doubt");
    this.#connection.read(length_mm);
  }

  #stored({ length_mm }) {
    this.sound.play("stored");
    this.#connection.read(length_mm);
    this.model.storedNow = true;
    this.#speak(this.texts.say("stored.spoken"));
    setTimeout(() => {
      this.model.storedNow = false;
      this.draw();
    }, STORED_MS);
  }

  #newStep(session) {
    this.dialogues.close();
    // At the end the list says what was left out: not what was skipped once and measured later.
    const unknown = session.step && !this.model.stepsById.has(session.step.id);
    if (unknown || hasEnded(session)) this.#loadSteps().catch(() => null);
    this.#loadScene().catch(() => null);
  }

  async #loadSteps() {
    const { steps } = await ask(`${this.#path}/steps`);
    this.model.steps = steps;
    this.model.stepsById = new Map(steps.map((step) => [step.id, step]));
    const last = steps.findLast(measured);
    this.model.stored ??= last ? { step_id: last.id, length_mm: last.length_mm } : null;
    this.draw();
  }

  async #loadScene() {
    const of = this.model.session.step?.id ?? null;
    const scene = await ask(`${this.#path}/scene`);
    if (of !== (this.model.session.step?.id ?? null)) return; // a newer one is on its way
    this.model.scene = scene;
    this.model.sceneOf = of;
    this.draw();
  }

  #linked(up) {
    this.model.up = up;
    if (!up && this.model.opened) this.sound.play("lost");
    this.model.opened ||= up;
    if (!up) this.model.sample = null;
    if (up) this.refresh().then(() => this.sender.flush(), () => this.sender.flush());
    this.draw();
  }

  // Not through `draw`: a length is on the screen as soon as it is here.
  #sampled(sample) {
    const other = sample.why_not !== this.model.sample?.why_not;
    this.model.sample = sample;
    this.#connection.see(sample);
    this.model.sampleOf = this.model.session?.step?.id;
    if (other) this.draw(); // the button says whether there is anything to store
    this.#showLength();
  }

  #showLength() {
    const { session, sample } = this.model;
    const screen = screenOf(session);
    this.gauge.show(sample, session?.step, { up: this.model.up || !this.model.opened, old: this.#connection.old });
    const state = READ.includes(screen) && sample ? sample.state : null;
    this.sound.state(state);
    if (state !== null) this.#speakState(state);
  }

  #speakState(state) {
    if (state === this.#speaking?.state) return;
    clearTimeout(this.#speaking?.timer);
    const timer = setTimeout(() => this.#speak(this.gauge.word(state)), SPOKEN_MS);
    this.#speaking = { state, timer };
  }

  #speak(text) {
    write(this.#at.spoken, text);
  }

  async #dropped(tap, error) {
    await this.refresh().catch(() => null);
    if (error.ofName) return this.#askName(error.message);
    const name = this.texts.say(ACTS[tap.act]);
    const gone = tap.step_id !== null && tap.step_id !== this.model.session?.step?.id;
    const step = this.model.stepsById.get(tap.step_id);
    if (gone) return this.say(this.texts.say("queue.dropped", { tap: name, step: step ? stepInWords(step, this.texts) : tap.step_id }));
    const reason = error.message || this.texts.say("queue.failed", { status: error.status });
    return this.say(this.texts.say("queue.refused", { tap: name, reason }));
  }

  #missing(error) {
    if (!(error instanceof Refused)) return; // the stream says when the service is back
    this.model.missing = error.status === NOT_FOUND;
    this.say(error.message || this.texts.say("queue.failed", { status: error.status }));
    this.draw();
  }
}

const storage = new Storage();
new SessionPage(await Texts.load(storage), storage).open();
