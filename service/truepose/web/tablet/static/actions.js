// The large buttons above the dock: what the screen is for.

import { element } from "./elements.js";
import { holdButton } from "./hold.js";
import { answeredBy, can, stepOf } from "./situation.js";
import { pairInWords } from "./words.js";

const DONE = { act: "confirm", key: "act.done" };
const STORE = { act: "store", key: "act.store" };
const OFFERED = {
  planned: [{ act: "start", key: "act.start" }],
  initialise: [STORE],
  measure_side: [STORE],
  connect_leg: [STORE],
  place_base: [DONE],
  fit_ball: [DONE],
  clamp_cup: [DONE],
  remove_ball: [DONE],
  detach: [DONE],
  move: [{ act: "confirm", key: "act.hold", held: true }],
  interrupted: [{ act: "confirm", key: "act.looked" }],
  // Held, like a motion: no tap by habit, or meant for the screen before, must accept another instrument.
  foreign: [{ act: "confirm", key: "foreign.accept", held: true }],
  moving: [{ key: "act.moving" }],
  precalibrate: [{ key: "act.wait" }],
  waiting: [{ key: "act.wait" }],
  loading: [{ key: "act.wait" }],
  missing: [],
  pausing: [{ key: "act.wait" }],
  paused: [{ act: "resume", key: "act.resume" }],
  doubt: [
    // The safe answer is the large coloured one: a tap by habit must not store a length against the evidence.
    { act: "answer", answer: "reconnected", key: "doubt.reconnected", exchanged: "doubt.read_again" },
    { act: "answer", answer: "right_pair", key: "doubt.right", plain: true },
  ],
  finished: [],
  aborted: [],
  failed: [],
};

const NOTHING = {
  no_signal: "store.no_signal",
  out_low: "store.out_low",
  out_high: "store.out_high",
  unstable: "store.unstable",
  no_length_here: "store.no_length_here",
};

// What the ballbar shows is no length that could be kept: then the button says so instead of inviting.
function nothingToStore(offer, model) {
  const idle = offer.act === "store" && model.sample?.can_store === false;
  return idle ? (NOTHING[model.sample.why_not] ?? NOTHING.no_signal) : null;
}

function label(offer, model, texts) {
  const why = nothingToStore(offer, model);
  if (why) return texts.say(why);
  if (offer.act && model.queue.holds(offer.act, stepOf(model.session, offer.act))) return texts.say("queue.waits");
  const { step, suspicion } = model.session ?? {};
  const key = (suspicion && offer[suspicion.kind]) || offer.key;
  const pair = step?.points ? pairInWords(step.points) : texts.say("initialise.names");
  return texts.say(key, { pair, answered: answeredBy(model.session) });
}

// A second tap of a gloved hand, meant for the screen before, must not answer the next one.
const FRESH_MS = 600;

export class Actions {
  #place;
  #on;
  #shown = "";
  #shown_ms = 0;
  #buttons = [];

  // `on`: { tapped(act, { answer }), settled() }
  constructor(place, on) {
    this.#place = place;
    this.#on = on;
  }

  show(screen, model, texts) {
    const offers = OFFERED[screen];
    // Built anew for a new step only: a finger may rest on a button while the rest of the page changes.
    const { step, prompt_id: prompt } = model.session ?? {};
    const shown = `${screen} ${step?.id} ${prompt ?? ""} ${answeredBy(model.session) ?? ""}`;
    if (shown !== this.#shown) this.#begin(shown, offers, texts, answeredBy(model.session));
    const fresh = performance.now() - this.#shown_ms < FRESH_MS;
    offers.forEach((offer, i) => {
      const button = this.#buttons[i];
      const idle = nothingToStore(offer, model) !== null;
      const offered = Boolean(offer.act) && can(model, offer.act) && !idle;
      // What must be held is no second tap.
      const early = fresh && !offer.held;
      button.disabled = early || !offered;
      button.classList.toggle("fresh", early && offered);
      button.classList.toggle("idle", idle);
      const text = button.classList.contains("holding") ? texts.say("act.hold_more") : label(offer, model, texts);
      if (button.lastChild.textContent !== text) button.lastChild.textContent = text;
    });
  }

  #begin(shown, offers, texts, answered) {
    this.#shown = shown;
    this.#shown_ms = performance.now();
    this.#buttons = offers.map((offer) => this.#button(offer, texts, answered));
    this.#place.replaceChildren(...this.#buttons);
    setTimeout(() => this.#on.settled(), FRESH_MS + 1);
  }

  #button(offer, texts, answered) {
    const kind = offer.held ? "main hold" : `main${offer.plain ? " plain" : ""}`;
    const fill = element("i", { class: "fill", "aria-hidden": "true" });
    const button = element("button", { type: "button", class: kind, "data-act": offer.act }, fill, element("span"));
    const tapped = () => this.#on.tapped(offer.act, { answer: offer.answer });
    const text = (holding) => texts.say(holding ? "act.hold_more" : offer.key, { answered });
    if (!offer.held) button.addEventListener("click", tapped);
    else holdButton(button, { held: tapped, changed: (holding) => (button.lastChild.textContent = text(holding)) });
    return button;
  }
}
