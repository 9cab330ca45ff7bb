// What the upper edge says of a ballbar session.

import { remaining } from "../common/remaining.js";
import { hasEnded } from "../common/situation.js";

function where({ step, state }, texts) {
  if (!step || state === "planned") return "";
  const said = [texts.say("top.step", { index: step.index, count: step.count })];
  if (step.placement !== null) said.push(texts.say("top.placement", { placement: step.placement }));
  if (step.leg_number) said.push(texts.say("top.leg", { config: step.config, leg: step.leg_number, legs: step.leg_count }));
  else if (step.config !== null) said.push(texts.say("top.pose", { config: step.config }));
  if (step.attempt > 1) said.push(texts.say("top.again", { attempt: step.attempt }));
  return texts.list(said);
}

function progress(session, texts) {
  const done = session.progress;
  const said = [texts.say("progress.readings", { readings: done.readings, planned: done.planned })];
  if (done.remaining_s !== null && !hasEnded(session)) said.push(remaining(done.remaining_s, texts));
  const skipped = done.skipped_poses;
  if (skipped) said.push(texts.say(skipped === 1 ? "progress.skipped_one" : "progress.skipped_many", { count: skipped }));
  return said.join(" · ");
}

function share({ progress: { readings, planned } }) {
  return planned ? readings / planned : 0;
}

export const SAYS = { where, progress, share };
