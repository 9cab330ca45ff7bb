// What the state of a session that runs by itself means for the page: which screen, which acts go at once. Pure.

const RESTING = ["paused", "pausing", "finished", "aborted", "failed"];
const OF_STEP = {
  instruments: "opening",
  "warm-up": "warm",
  "world-frame": "nests",
  "fixed-nests": "look",
  stop: "measure",
};
// Acts after which the arm may move, or which begin something: sent while somebody looks, or not at all.
const ONLY_NOW = ["start", "confirm", "resume"];

export const MOVING = ["ask", "foreign", "paused"]; // screens whose button lets the arm move; they say so

// `placed`: the person has been through the list of who and what.
export function screenOf(session, { missing = false, placed = false } = {}) {
  if (!session) return missing ? "missing" : "loading";
  if (session.state === "planned") return placed && session.kind !== "contacts" ? "place" : "who";
  if (RESTING.includes(session.state)) return session.state;
  if (session.state === "awaiting_confirmation") return askOf(session);
  return OF_STEP[session.step?.kind] ?? "waiting";
}

// The first questions of a session with gauges are about the gauges: nothing moves after them.
function askOf(session) {
  if (session.tracker_in_question) return "foreign";
  return ["fixture", "zero"].includes(session.step?.id) ? "handwork" : "ask";
}

export function onlyNow(session, act) {
  return ONLY_NOW.includes(act);
}

// What a person saw who lets the session go on.
export function seen(session, act) {
  if (!["confirm", "resume"].includes(act)) return {};
  const foreign = session?.tracker_in_question?.serial_number;
  return { ...(session?.prompt && { prompt_id: session.prompt.id }), ...(foreign && { accept_serial_number: foreign }) };
}

// What a tap of the dock is about: the row that is chosen, else the present step (skip) or what was done last.
export function subjectOf(session, act, chosen) {
  if (act === "back") return null;
  if (chosen !== null) return `stop-${chosen}`;
  return act === "skip" ? (session.step?.id ?? null) : null;
}
