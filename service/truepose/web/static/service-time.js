// When something is pressed, by the clock that the service tells with each of its answers.

let [told_s, heard_ms] = [null, 0];

export function hear(reply) {
  const said = reply.headers.get("Truepose-Time");
  if (said !== null) [told_s, heard_ms] = [Number(said), performance.now()];
  return reply;
}

// Never later than it is: an answer was under way too. Null: the service has not told it.
export function now_s() {
  return told_s === null ? null : told_s + (performance.now() - heard_ms) / 1000;
}
