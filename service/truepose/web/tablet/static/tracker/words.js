// What each screen says: the small line, the large words, the sentence.

import { reasonInWords } from "../common/reasons.js";

const PLAIN = {
  loading: ["loading.title", "loading.names", "loading.text"],
  missing: ["missing.title", "missing.names", "guided.missing"],
  waiting: ["waiting.title", "waiting.names", "waiting.text"],
  who: ["who_what.title", "who_what.names", "overview.text"],
  place: ["placing.title", "placing.names", "placing.text"],
  ask: ["asked.title", "move.names", "asked.text"],
  handwork: ["handwork.title", "handwork.names", null],
  foreign: ["other_tracker.title", "other_tracker.names", null],
  opening: ["opening.title", "opening.names", "opening.text"],
  warm: ["warm.title", "warm.names", "warm.text"],
  nests: ["nests.title", "nests.names", "nests.text"],
  look: ["look.title", "look.names", "look.text"],
  measure: ["measuring.title", "measuring.names", null],
  paused: ["paused.title", "paused.names", "guided.paused"],
  pausing: ["paused.title", "pausing.names", "pausing.text"],
  finished: ["finished.title", "finished.names", "guided.finished"],
  aborted: ["aborted.title", "aborted.names", "guided.aborted"],
  failed: ["failed.title", "failed.names", "guided.aborted"],
};
const GAUGES = { who: "who_what.gauges", measure: "measuring.gauges" };
const WHY = ["ask", "handwork", "foreign", "paused", "failed"]; // screens that say what the service asks, or why

export function wordsOf(screen, session, texts) {
  const [kicker, names, text] = PLAIN[screen];
  const values = { config: session?.step?.config, done: session?.progress.done, answered: session?.tracker_in_question?.serial_number };
  const instruction = session?.kind === "contacts" && GAUGES[screen] ? GAUGES[screen] : text;
  return {
    kicker: texts.say(kicker, values),
    names: texts.say(names, values),
    instruction: instruction === null ? "" : texts.say(instruction, values),
  };
}

// What the service asks, or why nothing goes on.
export function whyInWords(screen, session) {
  if (!WHY.includes(screen)) return null;
  return reasonInWords(session);
}
