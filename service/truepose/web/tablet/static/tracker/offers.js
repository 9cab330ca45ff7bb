// What the large buttons of each screen do.

const HELD = { act: "confirm", key: "act.hold", held: true };
const WAIT = [{ key: "act.wait" }];
const OFFERED = {
  who: [{ act: "place", key: "guided.to_place", local: true }],
  place: [{ act: "list", key: "guided.to_list", local: true, plain: true }, { act: "start", key: "act.start" }],
  ask: [HELD],
  handwork: [{ act: "confirm", key: "act.done" }],
  // Held, like a motion: no tap by habit may accept another instrument.
  foreign: [{ act: "confirm", key: "guided.accept", held: true }],
  paused: [{ act: "resume", key: "act.hold", held: true }],
  measure: [{ act: "look", key: "guided.look_now", local: true, plain: true }],
  warm: [{ act: "enough", key: "guided.warm_enough", local: true, plain: true }],
};
const LEFT = ["finished", "aborted", "failed", "missing"];

// Of a session with gauges there is no instrument to place.
function offersOf(screen, session) {
  if (screen === "who" && session?.kind === "contacts") return [{ act: "start", key: "act.start" }];
  if (screen === "measure" && session?.kind !== "tracker") return WAIT;
  return OFFERED[screen] ?? (LEFT.includes(screen) ? [] : WAIT);
}

const foreign = (session) => session?.tracker_in_question?.serial_number;

export const OFFERS = {
  of: offersOf,
  values: (session) => ({ answered: foreign(session) }),
  named: foreign,
  label: (offer, model, texts) => texts.say(offer.key, { answered: foreign(model.session) }),
  nothing: () => null,
};
