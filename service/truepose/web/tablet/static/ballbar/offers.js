// What the large buttons of each screen do.

import { answeredBy } from "./situation.js";
import { pairInWords } from "./words.js";

const DONE = { act: "confirm", key: "act.done" };
const STORE = { act: "store", key: "act.store" };
const RECONNECTED = { act: "answer", answer: "reconnected", key: "doubt.reconnected", exchanged: "doubt.read_again" };
const RIGHT = { act: "answer", answer: "right_pair", key: "doubt.right" };
const plain = (offer) => ({ ...offer, plain: true });
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
    RECONNECTED,
    plain(RIGHT),
  ],
  doubt_in_vain: [RIGHT, plain(RECONNECTED)],
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

function label(offer, model, texts) {
  const { step, suspicion } = model.session ?? {};
  const key = (suspicion && offer[suspicion.kind]) || offer.key;
  const pair = step?.points ? pairInWords(step.points) : texts.say("initialise.names");
  return texts.say(key, { pair, answered: answeredBy(model.session) });
}

// What the ballbar shows is no length that could be kept: then the button says so instead of inviting.
function nothing(offer, model) {
  const idle = offer.act === "store" && model.sample?.can_store === false;
  return idle ? (NOTHING[model.sample.why_not] ?? NOTHING.no_signal) : null;
}

export const OFFERS = {
  of: (screen, session) => OFFERED[screen === "doubt" && session?.main_answer === "right_pair" ? "doubt_in_vain" : screen],
  values: (session) => ({ answered: answeredBy(session) }),
  named: answeredBy,
  label,
  nothing,
};
