// What the upper edge says of a session that runs by itself.

import { remaining } from "../common/remaining.js";
import { hasEnded } from "../common/situation.js";

const STEPS = {
  instruments: "guided.step_instruments", "warm-up": "guided.step_warm", "world-frame": "guided.step_nests",
  "fixed-nests": "guided.step_look", question: "guided.step_hands",
};

function where({ step, state }, texts) {
  if (!step || ["planned", "finished", "aborted", "failed"].includes(state)) return "";
  return step.kind === "stop" ? texts.say("guided.step_stop", { config: step.config }) : texts.say(STEPS[step.kind]);
}

function progress(session, texts) {
  const { done, planned, skipped, remaining_s } = session.progress;
  const said = [texts.say("guided.measured", { done, planned })];
  if (skipped) said.push(texts.say("guided.left_out", { skipped }));
  if (remaining_s !== null && !hasEnded(session)) said.push(remaining(remaining_s, texts));
  return said.join(" · ");
}

function share({ progress: { done, skipped, planned } }) {
  return planned ? (done + skipped) / planned : 0;
}

export const SAYS = { where, progress, share };
