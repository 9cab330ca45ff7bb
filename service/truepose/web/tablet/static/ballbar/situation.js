// What a session's state means for the page: which screen, which acts go at once. Pure.

const RESTING = ["paused", "pausing", "planned", "finished", "aborted", "failed"];
export const READ = ["initialise", "measure_side", "connect_leg"]; // a length is read on these screens

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

// An old confirmation must not move a robot.
export function onlyNow(session, act) {
  return ONLY_NOW.includes(act) || (act === "confirm" && ["move", "interrupted", "foreign"].includes(screenOf(session)));
}

// Nothing shows that the ballbar is off where it has to be: a person says how they know.
export function takesReason(session, sample, act) {
  return act === "confirm" && ["detach", "move"].includes(screenOf(session)) && sample?.reason_needed === true;
}

// The serial number of a ballbar that waits to be accepted.
export function answeredBy(session) {
  return session?.ballbar_in_question?.serial_number;
}

// What a person saw who lets the session go on: the question, and of a confirmation also the cell at that moment and
// the ballbar that waits to be accepted.
export function seen(session, sample, act) {
  if (!["confirm", "resume"].includes(act)) return {};
  const asked = session.prompt ? { prompt_id: session.prompt.id } : {};
  if (act === "resume") return asked;
  const serial = answeredBy(session);
  return { ...asked, seen_time_s: sample?.time_s, ...(serial && { accept_serial_number: serial }) };
}
