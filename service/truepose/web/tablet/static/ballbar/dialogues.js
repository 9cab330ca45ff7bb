// What only the page of a ballbar session asks.

import { Dialogues } from "../common/dialogues.js";
import { element } from "../common/elements.js";

const OTHER = "skip.other";
const LENGTH = ["skip.short", "skip.long", "skip.unstable"];
const HANDS = ["skip.blocked", "skip.reach"];
const REASONS = { measure_side: [...LENGTH, ...HANDS, OTHER], precalibrate: ["skip.cannot", OTHER] };
const OF_POSE = [...LENGTH, ...HANDS, OTHER];
const OF_OTHERS = [...HANDS, "skip.cannot", OTHER];
const OUT = { out_low: "skip.short", out_high: "skip.long", unstable: "skip.unstable" };

export class BallbarDialogues extends Dialogues {
  // `step`: of a pose the whole rest is skipped.
  skip(step, sampleState, chosen) {
    const inPose = step.config !== null;
    const reasons = REASONS[step.kind] ?? (inPose ? OF_POSE : OF_OTHERS);
    const given = reasons.includes(OUT[sampleState]) ? OUT[sampleState] : null;
    const title = inPose ? "skip.title" : "skip.title_step";
    this.reasoned({ title, text: inPose ? "skip.text" : null, does: "skip.do", reasons, given, other: OTHER }, chosen);
  }

  // `pairs`: [base, tool] each; the simulated hands connect the one that is tapped.
  pairs(pairs, chosen) {
    const button = ([base, tool]) =>
      element("button", { type: "button", class: "pair", onclick: () => (this.leave(), chosen(base, tool)) }, `B${base}–T${tool}`);
    this.put({ title: "hands.pick", parts: () => [element("div", { class: "pairs" }, ...pairs.map(button))] });
  }
}
