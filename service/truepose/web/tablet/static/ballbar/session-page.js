// One ballbar session, a step a screen: everything is joined here.

import { Actions } from "../common/actions.js";
import { answerTo, ask } from "../common/api.js";
import { Caution } from "../common/caution.js";
import { Dock } from "../common/dock.js";
import { showIf, write } from "../common/elements.js";
import { Page } from "../common/page.js";
import { hasEnded } from "../common/situation.js";
import { Storage } from "../common/tablet.js";
import { Texts } from "../common/texts.js";
import { Top } from "../common/top.js";
import { Connection } from "./connection.js";
import { BallbarDialogues } from "./dialogues.js";
import { Gauge } from "./gauge.js";
import { Hands } from "./hands.js";
import { OFFERS } from "./offers.js";
import { READ, onlyNow, screenOf, seen, takesReason } from "./situation.js";
import { Stage } from "./stage.js";
import { SAYS } from "./top.js";
import { stepInWords } from "./words.js";

const STORED_MS = 2600;
const SPOKEN_MS = 700; // a state is spoken once it has lasted
const ASKS = ["planned", "move", "interrupted", "foreign"]; // screens with a button that lets the arm move

// An outcome, or a listed step with its outcome, that kept a length.
const measured = (said) => [said?.kind, said?.outcome].includes("measured") && said.length_mm !== null;

// After a pause the same step comes back: where that is a motion, it follows.
function mayMove(screen, session) {
  return ASKS.includes(screen) || (screen === "paused" && session.step?.kind === "move");
}

class SessionPage extends Page {
  #connection = new Connection();
  #handsExist = false;
  #speaking = null;

  constructor(texts, storage) {
    super(texts, storage, { path: `/api/v1/sessions/${document.body.dataset.session}`, onlyNow });
    Object.assign(this.model, { steps: [], stepsById: new Map(), scene: null, sceneOf: null, sampleOf: null, stored: null, storedNow: false });
    this.#furnish();
  }

  open() {
    super.open();
    this.hands.exist().then((exist) => ((this.#handsExist = exist), this.draw()));
  }

  #furnish() {
    const at = this.at;
    this.top = new Top(at, SAYS);
    this.stage = new Stage(at, () => this.draw());
    this.caution = new Caution(at.caution);
    this.gauge = new Gauge(at, this.texts);
    this.dialogues = new BallbarDialogues(at.dialogue, this.texts);
    this.dock = new Dock(at.dock, (act) => this.#tapped(act));
    this.actions = new Actions(at.actions, OFFERS, { tapped: (act, more) => this.act(act, more), settled: () => this.draw() });
    this.hands = new Hands(at.hands, {
      present: () => this.model.session,
      pairs: () => this.#pairs(),
      other: (chosen) => this.dialogues.pairs(this.#pairs(), chosen),
      failed: (sentence) => this.say(sentence || this.texts.say("hands.unreached")),
    });
  }

  show() {
    const { session } = this.model;
    const screen = screenOf(session, this.model.missing);
    this.top.show(this.model, this.texts);
    this.stage.show(screen, this.model, this.texts);
    this.dock.show(this.model, this.texts);
    this.caution.show(mayMove(screen, session), session);
    this.actions.show(screen, this.model, this.texts);
    this.#showLength();
    this.#showSimulated();
    showIf(this.at.trouble, Boolean(session?.trouble)); // the disk refuses: nothing is stored, and nothing moves
    write(this.at.trouble, session?.trouble ?? "");
  }

  taken(before, session) {
    if (measured(session.last_outcome)) this.model.stored = session.last_outcome;
    if (before) this.#news(before, session);
    else if (session.suspicion) this.#connection.read(session.suspicion.length_mm);
    if (before?.step?.id !== session.step?.id || before?.state !== session.state) this.#newStep(session);
  }

  async reload() {
    await this.#loadSteps();
    await this.#loadScene();
  }

  act(act, more = {}) {
    const { session, sample } = this.model;
    if (this.tablet.person && !more.reason && takesReason(session, sample, act))
      return this.dialogues.off((reason) => this.act(act, { ...more, reason }));
    if (act === "retry" && this.tablet.person) this.#connection.renew(); // the service reads at once then
    return super.act(act, more);
  }

  seen(act) {
    return seen(this.model.session, this.model.sample, act);
  }

  #tapped(act) {
    const { session, sample } = this.model;
    if (act === "abort") return this.dialogues.abort(() => this.act("abort"));
    if (act !== "skip") return this.act(act);
    const step = session.step.id;
    const chosen = (reason) => this.act("skip", { reason, step_id: step });
    return this.dialogues.skip(session.step, sample?.state, chosen);
  }

  #pairs() {
    const points = this.model.scene?.points ?? [];
    const numbers = (kind) => points.filter((point) => point.kind === kind).map((point) => Number(point.name.slice(1)));
    return numbers("cup").flatMap((base) => numbers("nest").map((tool) => [base, tool]));
  }

  // The record says whether it is simulated. Hands are there wherever the service's cell has some: one whose
  // simulated devices are named one by one is no simulated cell to its record.
  #showSimulated() {
    const at = this.at;
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
    if (this.#speaking?.timer) { // a state that was about to be spoken waits, so that this is heard
      clearTimeout(this.#speaking.timer);
      this.#speaking = null;
    }
    this.speak(this.texts.say("stored.spoken"));
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
    const { steps } = await answerTo(() => ask(`${this.path}/plan`));
    this.model.steps = steps;
    this.model.stepsById = new Map(steps.map((step) => [step.id, step]));
    const last = steps.findLast(measured);
    this.model.stored ??= last ? { step_id: last.id, length_mm: last.length_mm } : null;
    this.draw();
  }

  async #loadScene() {
    const of = this.model.session.step?.id ?? null;
    const scene = await answerTo(() => ask(`${this.path}/scene`));
    if (of !== (this.model.session.step?.id ?? null)) return; // a newer one is on its way
    this.model.scene = scene;
    this.model.sceneOf = of;
    this.draw();
  }

  // Not through `draw`: a length is on the screen as soon as it is here.
  sampled(sample) {
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
    const timer = setTimeout(() => {
      this.#speaking.timer = null;
      this.speak(this.gauge.word(state));
    }, SPOKEN_MS);
    this.#speaking = { state, timer };
  }

  stepInWords(id) {
    const step = this.model.stepsById.get(id);
    return step ? stepInWords(step, this.texts) : id;
  }
}

const storage = new Storage();
new SessionPage(await Texts.load(storage), storage).open();
