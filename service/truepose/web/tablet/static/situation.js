// What a session's state means for the page: which screen, which acts. Pure.

const ENDED = ["finished", "aborted", "failed"];
const RESTING = ["paused", "pausing", "planned", ...ENDED];
export const READ = ["initialise", "measure_side", "connect_leg"]; // a length is read on these screens

// Acts that belong to a step: the service refuses them when that step is gone.
export const OF_STEP = ["confirm", "store", "answer", "retry", "skip", "back"];
// Acts that set something going: they are sent while somebody looks at the cell, or not at all.
const ONLY_NOW = ["start", "resume", "hand_over"];

export function screenOf(session, missing = false) {
  if (!session) return missing ? "missing" : "loading";
  if (RESTING.includes(session.state)) return session.state;
  if (session.robot_moving) return "moving";
  // After a stop or a restart of the service: nothing goes on before a person has looked.
  if (session.state === "awaiting_confirmation") return session.ballbar_in_question ? "foreign" : "interrupted";
  if (session.suspicion) return "doubt";
  return session.step?.kind ?? "waiting";
}

export function hasEnded(session) {
  return ENDED.includes(session.state);
}

export function actsHere(session, tablet) {
  return !session.acting || session.acting.tablet === tablet;
}

// An old confirmation must not move a robot.
export function onlyNow(session, act) {
  return ONLY_NOW.includes(act) || (act === "confirm" && ["move", "interrupted", "foreign"].includes(screenOf(session)));
}

// Nothing shows that the ballbar is off where it has to be: a person says how they know.
export function takesReason(session, sample, act) {
  return act === "confirm" && ["detach", "move"].includes(screenOf(session)) && sample?.reason_needed === true;
}

function offered(session, act) {
  if (act === "start") return session.state === "planned";
  return session.acts.includes(act);
}

// `model`: { session, up, tablet, queue }
export function can({ session, up, tablet, queue }, act) {
  if (!session || !offered(session, act)) return false;
  if (!up && onlyNow(session, act)) return false;
  if (queue.holds(act, stepOf(session, act))) return false;
  // Whoever sees danger stops the robot, watching or acting.
  return act === "stop" || actsHere(session, tablet.id);
}

export function stepOf(session, act) {
  return OF_STEP.includes(act) ? (session.step?.id ?? null) : null;
}

// The serial number of a ballbar that waits to be accepted.
export function answeredBy(session) {
  return session?.ballbar_in_question?.serial_number;
}

// What a person saw who lets the session go on: the question, and of a confirmation also the cell at that moment and
// the ballbar that waits to be accepted.
export function seen(session, sample, act) {
  if (!["confirm", "resume"].includes(act)) return {};
  const asked = session.prompt_id ? { prompt_id: session.prompt_id } : {};
  if (act === "resume") return asked;
  const serial = answeredBy(session);
  return { ...asked, seen_time_s: sample?.time_s, ...(serial && { accept_serial_number: serial }) };
}
