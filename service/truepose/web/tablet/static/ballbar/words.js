// What each screen says: the small line, the large names, the sentence.

import { answeredBy } from "./situation.js";

const PLAIN = {
  loading: ["loading.title", "loading.names", "loading.text"],
  missing: ["missing.title", "missing.names", "missing.text"],
  waiting: ["waiting.title", "waiting.names", "waiting.text"],
  planned: ["overview.title", null, "overview.text"],
  paused: ["paused.title", "paused.names", "paused.text"],
  pausing: ["paused.title", "pausing.names", "pausing.text"],
  interrupted: ["interrupted.title", "interrupted.names", "interrupted.text"],
  foreign: ["foreign.title", "foreign.names", "foreign.text"],
  moving: ["moving.title", "move.names", "moving.text"],
  move: ["move.away", "move.names", "move.text"],
  initialise: ["initialise.title", "initialise.names", "initialise.text"],
  place_base: ["place.title", "place.names", "place.text"],
  fit_ball: ["ball.title", "ball.names", "ball.text"],
  remove_ball: ["unball.title", "unball.names", "unball.text"],
  clamp_cup: ["clamp.title", null, "clamp.text"],
  connect_leg: ["leg.title", null, "leg.text"],
  detach: ["detach.title", "detach.names", "detach.text"],
  precalibrate: ["computing.title", "computing.names", "computing.text"],
  doubt: ["doubt.title", null, "doubt.look"],
  finished: ["finished.title", "finished.names", "finished.text"],
  aborted: ["aborted.title", "aborted.names", "aborted.text"],
  failed: ["failed.title", "failed.names", "failed.text"],
};
const SIDES = { tool: "side.title_tool", base: "side.title_base" };

export function barsInWords(bars_mm, texts) {
  const [first, second] = bars_mm ?? [];
  const list = (bars_mm ?? []).join(" + ");
  const key = ["bars.none", "bars.one", "bars.two"][bars_mm?.length ?? 0] ?? "bars.many";
  return texts.say(key, { first, second, list });
}

export const pairInWords = (points) => points.join("–");

function values(session, texts) {
  const step = session?.step;
  const [first, second] = step?.points ?? [];
  return {
    first,
    second,
    cup: `B${step?.base_point}`,
    config: step?.config,
    placement: step?.placement,
    bars: barsInWords(step?.bars_mm, texts),
    readings: session?.progress.readings,
    reason: session?.reason ?? "",
    answered: answeredBy(session),
    wanted: session?.ballbar_in_question?.expected_serial_number,
  };
}

function title(screen, session, texts) {
  const step = session?.step;
  if (screen === "measure_side") return texts.say(SIDES[step.artefact]);
  if (screen !== "move") return texts.say(PLAIN[screen][0]);
  if (step.config !== null) return texts.say("move.to_pose", { config: step.config });
  return step.base_point === null ? texts.say(PLAIN.move[0]) : texts.say("move.to_cup", { cup: `B${step.base_point}` });
}

// The names of points that the screen is about; none where it is about something else.
export function pointsOf(screen, session) {
  const step = session?.step;
  if (["connect_leg", "measure_side", "doubt"].includes(screen)) return step.points ?? [];
  return screen === "clamp_cup" ? [`B${step.base_point}`] : [];
}

export function wordsOf(screen, session, texts) {
  const said = values(session, texts);
  const [, plain, text] = screen === "measure_side" ? [null, null, "side.text"] : PLAIN[screen];
  const points = pointsOf(screen, session);
  // A doubt about the calibrator is about no pair.
  const names = plain ?? (screen === "doubt" && !points.length ? "initialise.names" : null);
  return {
    kicker: title(screen, session, texts),
    points,
    names: names && texts.say(names, said),
    instruction: texts.say(text, said),
  };
}

// A step in a few words, for lists and for sentences about a step that is gone.
export function stepInWords(step, texts) {
  if (step.kind === "move") return title("move", { step }, texts);
  const words = wordsOf(step.kind, { step, progress: {} }, texts);
  const what = words.points.length ? pairInWords(words.points) : words.names;
  return `${words.kicker}: ${what}`;
}
