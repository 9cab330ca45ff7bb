// What a session's state means for every kind of session: who acts, and which acts can be done now. Pure.

const ENDED = ["finished", "aborted", "failed"];

// Acts that belong to a step: the service refuses them when that step is gone.
const OF_STEP = ["confirm", "store", "answer", "retry", "skip", "back"];

export function hasEnded(session) {
  return ENDED.includes(session.state);
}

export function actsHere(session, tablet) {
  return !session.acting || session.acting.tablet === tablet;
}

function offered(session, act) {
  if (act === "start") return session.state === "planned";
  return session.commands.includes(act);
}

// `model`: { session, up, tablet, queue, onlyNow }; `onlyNow(session, act)`: it is sent while somebody looks at the
// cell, or not at all.
export function can({ session, up, tablet, queue, onlyNow }, act) {
  if (!session || !offered(session, act)) return false;
  if (!up && onlyNow(session, act)) return false;
  if (queue.holds(act, stepOf(session, act))) return false;
  // Whoever sees danger stops the robot, watching or acting.
  return act === "stop" || actsHere(session, tablet.id);
}

export function stepOf(session, act) {
  return OF_STEP.includes(act) ? (session.step?.id ?? null) : null;
}
