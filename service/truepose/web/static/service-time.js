// When something is pressed, by the clock that the service tells with each of its answers.
//
// An answer was under way for an unknown while, so it says only that it is at least so late; of all that were
// heard the one that was quickest is believed. Never later than it is: a tap that is old must not look new.

const DRIFT = 1e-3; // a tablet's clock may run faster than the service's, at most by so much
const OTHER_CLOCK_MS = 10_000; // nobody waits for an answer for so long: the host was started anew

let [ahead_ms, heard_ms] = [null, 0];

export function hear(reply) {
  const said = reply.headers.get("Truepose-Time");
  if (said !== null) believe(1000 * Number(said), performance.now());
  return reply;
}

function believe(told_ms, at_ms) {
  const known_ms = aheadAt(at_ms);
  const least_ms = told_ms - at_ms;
  const slow = known_ms !== null && least_ms < known_ms && least_ms > known_ms - OTHER_CLOCK_MS;
  [ahead_ms, heard_ms] = [slow ? known_ms : least_ms, at_ms];
}

const aheadAt = (at_ms) => (ahead_ms === null ? null : ahead_ms - DRIFT * (at_ms - heard_ms));

// Null: the service has not told it.
export function now_s() {
  const at_ms = performance.now();
  return ahead_ms === null ? null : (at_ms + aheadAt(at_ms)) / 1000;
}
