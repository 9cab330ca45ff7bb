// One session that runs by itself, guided step by step: everything is joined here.

import { Actions } from "../common/actions.js";
import { answerTo, ask } from "../common/api.js";
import { Caution } from "../common/caution.js";
import { Dialogues } from "../common/dialogues.js";
import { Dock } from "../common/dock.js";
import { showIf, write } from "../common/elements.js";
import { Page } from "../common/page.js";
import { Storage } from "../common/tablet.js";
import { Texts } from "../common/texts.js";
import { Top } from "../common/top.js";
import { OFFERS } from "./offers.js";
import { MOVING, onlyNow, screenOf, seen, subjectOf } from "./situation.js";
import { Stage } from "./stage.js";
import { SAYS } from "./top.js";
import { Watch } from "./watch.js";

const MEASURED_MS = 2600;
const AGAIN_MS = 700; // the tables are read anew no more often
const NEAR_TONE_MS = 250;
const OUTLOOK_MS = 60_000; // it is worked out while one waits
const PROMISED_EVERY = 5; // configurations
const FARTHEST = 1000; // tolerances from which the tone begins to rise
const OTHER = "skip.other";
const REASONS = ["leave.beam", "leave.reflector", "leave.touched", "leave.reach", OTHER];
const ENOUGH = ["enough.warm_before", "enough.no_time", OTHER];

class SessionPage extends Page {
  #reading = false;
  #stale = false;
  #promised = -1;
  #toned_ms = 0;

  constructor(texts, storage) {
    const path = `/api/v1/sessions/${document.body.dataset.session}`;
    super(texts, storage, { path, onlyNow });
    Object.assign(this.model, { sheet: null, scene: null, devices: [], outlook: null, placed: false, measuredNow: false });
    this.#furnish();
  }

  #furnish() {
    const at = this.at;
    this.top = new Top(at, SAYS);
    this.stage = new Stage(at, { redraw: () => this.draw(), chosen: () => this.draw() });
    this.watch = new Watch(at);
    this.caution = new Caution(at.caution);
    this.dialogues = new Dialogues(at.dialogue, this.texts);
    this.dock = new Dock(at.dock, (act) => this.#tapped(act));
    this.actions = new Actions(at.actions, OFFERS, { tapped: (act) => this.#offered(act), settled: () => this.draw() });
  }

  show() {
    const { session } = this.model;
    const screen = screenOf(session, this.model);
    this.top.show(this.model, this.texts);
    this.stage.show(screen, this.model, this.texts, this.texts.units);
    this.dock.show(this.model, this.texts);
    this.caution.show(MOVING.includes(screen), session);
    this.actions.show(screen, this.model, this.texts);
    this.#showWatch();
    showIf(this.at.simulated, session?.simulated === true);
  }

  taken(before, session) {
    if (before && session.last_stop && session.last_stop.number !== before.last_stop?.number) this.#stopEnded(session.last_stop);
    const asks = session.state === "awaiting_confirmation";
    if (before && asks && before.prompt?.id !== session.prompt?.id) this.sound.play("move");
    if (before?.step?.id !== session.step?.id || before?.state !== session.state) this.dialogues.close();
    if (before && before.ledger_number !== session.ledger_number) this.#readAnew();
  }

  async reload() {
    await this.#read();
    this.model.devices = await answerTo(() => ask("/api/v1/devices")).then((found) => found.items ?? found, () => []);
    this.draw();
  }

  seen(act) {
    return seen(this.model.session, act);
  }

  // The service says itself what it could not do; what was meant need not be the present step.
  isGone() {
    return false;
  }

  #tapped(act) {
    const { session } = this.model;
    if (act === "abort") return this.dialogues.abort(() => this.act("abort"));
    const step_id = subjectOf(session, act, this.stage.table.chosen);
    if (act === "skip") return this.#leaveOut(step_id);
    if (act === "resume") return this.say(this.texts.say("guided.hold_above"));
    const done = this.act(act, ["retry", "back"].includes(act) ? { step_id } : {});
    this.#letGo();
    return done;
  }

  #letGo() {
    this.stage.table.chosen = null;
    this.draw();
  }

  #offered(act) {
    if (act === "place" || act === "list") return (this.model.placed = act === "place"), this.draw();
    if (act === "look") return this.act("retry", { step_id: "fixed-nests" });
    if (act === "enough") return this.#leaveOut("warm-up");
    return this.act(act);
  }

  // With its reason: of a configuration, or of the rest of the warm-up.
  #leaveOut(step_id) {
    const warms = step_id === "warm-up";
    const config = step_id?.split("-")[1];
    const asked = { title: warms ? "enough.title" : "leave.title", text: warms ? "enough.text" : "leave.text", values: { config }, does: warms ? "enough.do" : "leave.do" };
    this.dialogues.reasoned({ ...asked, reasons: warms ? ENOUGH : REASONS, given: null, other: OTHER }, (reason) => {
      this.act("skip", { reason, step_id });
      this.#letGo();
    });
  }

  #stopEnded({ measured }) {
    this.sound.play(measured ? "stored" : "doubt");
    this.model.measuredNow = measured;
    setTimeout(() => {
      this.model.measuredNow = false;
      this.draw();
    }, MEASURED_MS);
  }

  // Lines come faster than tables are worth reading; the newest state is read in the end.
  async #readAnew() {
    this.#stale = true;
    if (this.#reading) return;
    this.#reading = true;
    while (this.#stale) {
      this.#stale = false;
      await this.#read().catch(() => null);
      await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
    }
    this.#reading = false;
  }

  async #read() {
    const [sheet, scene] = await Promise.all(["sheet", "scene"].map((part) => answerTo(() => ask(`${this.path}/${part}`))));
    Object.assign(this.model, { sheet, scene });
    this.draw();
    this.#askOutlook();
  }

  async #askOutlook() {
    const { done } = this.model.session?.progress ?? { done: 0 };
    const due = Math.floor(done / PROMISED_EVERY);
    if (due === this.#promised || this.model.session?.kind === "contacts") return;
    this.#promised = due;
    this.model.outlook = await answerTo(() => ask(`${this.path}/outlook`, {}, OUTLOOK_MS)).catch(() => this.model.outlook);
    this.draw();
  }

  // Not through `draw`: a distance is on the screen as soon as it is here.
  sampled(sample) {
    const other = sample.fixed_nest !== this.model.sample?.fixed_nest;
    this.model.sample = sample;
    if (other) this.draw();
    this.#showWatch();
  }

  #showWatch() {
    const { session, sample, up, opened } = this.model;
    const searching = ["warm-up", "world-frame"].includes(session?.step?.kind);
    this.watch.show(sample, { texts: this.texts, units: this.texts.units, up: up || !opened, searching });
    const still = sample && !sample.is_moving && !this.at.watch.hidden ? sample : null;
    this.sound.state(still?.state === "within" ? "in_range" : null);
    if (still?.distance_mm && still.state !== "within") this.#tone(still);
  }

  #tone({ distance_mm, tolerance_mm }) {
    if (performance.now() - this.#toned_ms < NEAR_TONE_MS) return;
    this.#toned_ms = performance.now();
    const away = Math.log(distance_mm / tolerance_mm) / Math.log(FARTHEST);
    this.sound.near(1 - Math.min(1, Math.max(0, away)));
  }

  stepInWords(id) {
    return id;
  }
}

const storage = new Storage();
new SessionPage(await Texts.load(storage, ["common", "tracker"]), storage).open();
