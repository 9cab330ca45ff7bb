// The live length: number, colour, word, shape, a scale, and how long it has stood still.

import { drawn, write } from "../common/elements.js";
import { stateShape } from "../common/shapes.js";
import { barsInWords } from "./words.js";

const WORDS = {
  in_range: "state.in_range",
  out_low: "state.out_low",
  out_high: "state.out_high",
  unstable: "state.unstable",
  no_signal: "state.no_signal",
};
const ADVICE = { unstable: "advice.unstable", no_signal: "advice.no_signal" };
const OUT = {
  pose: { out_low: "advice.out_low", out_high: "advice.out_high" },
  side: { out_low: "advice.out_low_side", out_high: "advice.out_high_side" },
  other: { out_low: "advice.out_low_set", out_high: "advice.out_high_set" },
};
const OVERDUE_MS = 2500;
const RANGE_MM = 1.0; // of the ballbar, either way of its nominal length
const SHOWN_MM = 1.25; // the scale goes so far either way
const SCALE = { width: 720, top: 14, height: 28 };

const onScale = (deviation_mm) => {
  const share = Math.max(-1, Math.min(1, deviation_mm / SHOWN_MM));
  return (SCALE.width / 2) * (1 + 0.985 * share);
};

function ticks() {
  const marks = [];
  for (let tenth = -10; tenth <= 10; tenth += 2) {
    const x = onScale(tenth / 10);
    const long = tenth % 10 === 0;
    marks.push(`M${x} ${SCALE.top + SCALE.height}v${long ? 16 : 9}`);
  }
  return marks.join("");
}

// Moves a mark to a deviation; null hides it.
function place(mark, deviation_mm) {
  const at = deviation_mm === null ? null : `translate(${onScale(deviation_mm)} 0)`;
  mark.toggleAttribute("hidden", at === null);
  if (at !== null && mark.getAttribute("transform") !== at) mark.setAttribute("transform", at);
}

// A leg may be out of reach, and so may a base that the robot's own errors placed; a tool triangle may not.
function outOf(step) {
  if (step?.kind === "connect_leg") return OUT.pose;
  return step?.kind === "measure_side" && step.artefact === "base" ? OUT.side : OUT.other;
}

// What the ballbar is off its nominal length; its own word where the service computed no length.
function deviationOf(sample, step) {
  if (sample.deviation_mm !== null) return sample.deviation_mm;
  if (sample.length_mm !== null && step?.nominal_mm) return sample.length_mm - step.nominal_mm;
  return { out_low: -SHOWN_MM, out_high: SHOWN_MM }[sample.state] ?? null;
}

export class Gauge {
  #nodes;
  #texts;
  #state = null;
  #marks = null; // of the scale, what moves on it
  #still = { step: null, since_ms: null }; // since when the length of this step could have been stored

  constructor(nodes, texts) {
    this.#nodes = nodes;
    this.#texts = texts;
  }

  // `sample` is null where nothing was received for the present step; `old`: the bar sits where it was read.
  show(sample, step, { up, old }) {
    const shown = sample ?? { state: "no_signal", length_mm: null, deviation_mm: null, stable_share: 0, robot_still: true };
    const { gauge, word, length, deviation, advice } = this.#nodes;
    this.#showState(shown.state);
    gauge.style.setProperty("--stable", shown.stable_share);
    write(word, this.#texts.say(up ? WORDS[shown.state] : "link.lost"));
    write(length, this.#length(shown, step));
    write(deviation, this.#deviation(shown, step));
    write(advice, up ? this.#advice(shown, step, old) : this.#texts.say("advice.offline"));
    this.#drawScale(shown, step);
    // For whoever measures how old the number on the screen is.
    gauge.dataset.sampledAtMs = shown.sampled_at_ms ?? "";
  }

  word(state) {
    return this.#texts.say(WORDS[state]);
  }

  #showState(state) {
    if (state === this.#state) return;
    this.#state = state;
    this.#nodes.gauge.dataset.state = state;
    document.body.dataset.length = state;
    this.#nodes.shape.replaceChildren(stateShape(state));
  }

  #length(sample, step) {
    const texts = this.#texts;
    if (sample.length_mm !== null) return texts.units.length(sample.length_mm, texts);
    if (sample.deviation_mm !== null && step?.kind === "initialise")
      return texts.units.difference(sample.deviation_mm, texts);
    return texts.say("length.none");
  }

  #deviation(sample, step) {
    const texts = this.#texts;
    const expected_mm = step?.expected_mm ?? step?.nominal_mm;
    if (sample.length_mm === null || !expected_mm) return "";
    const deviation = texts.units.signed(sample.length_mm - expected_mm, texts);
    return texts.say("length.deviation", { deviation, expected: texts.units.number(expected_mm, texts) });
  }

  #advice(sample, step, old) {
    const overdue = this.#overdue(sample, step);
    if (old && sample.state === "in_range") return this.#texts.say("advice.old");
    if (overdue) return this.#texts.say("advice.overdue");
    if (sample.state === "in_range") return this.#texts.say(sample.robot_still ? "advice.stable" : "advice.robot");
    const key = ADVICE[sample.state] ?? outOf(step)[sample.state];
    return this.#texts.say(key, { bars: barsInWords(step?.bars_mm, this.#texts) });
  }

  // The service stores no connection twice by itself; a person who did not move the bar must be told.
  #overdue(sample, step) {
    const ready = sample.state === "in_range" && sample.robot_still && sample.stable_share >= 1;
    if (!ready || this.#still.step !== step?.id) this.#still = { step: step?.id, since_ms: null };
    if (ready) this.#still.since_ms ??= performance.now();
    return ready && performance.now() - this.#still.since_ms > OVERDUE_MS;
  }

  // The scale stays, and only what has moved is painted again: samples arrive many times a second.
  #drawScale(sample, step) {
    this.#marks ??= this.#drawnScale();
    const aim_mm = (step?.expected_mm ?? NaN) - (step?.nominal_mm ?? NaN);
    place(this.#marks.aim, Math.abs(aim_mm) < SHOWN_MM ? aim_mm : null);
    place(this.#marks.needle, deviationOf(sample, step));
  }

  #drawnScale() {
    const [low, high] = [onScale(-RANGE_MM), onScale(RANGE_MM)];
    const { top, height, width } = SCALE;
    const aim = drawn("path", { class: "aim", d: `M0 ${top - 2}l-8-12h16Z` });
    const needle = drawn("rect", { class: "needle", x: -4, y: top - 4, width: 8, height: height + 8, rx: 3 });
    this.#nodes.scale.replaceChildren(
      drawn("rect", { class: "beyond", x: 0, y: top, width, height }),
      drawn("rect", { class: "within", x: low, y: top, width: high - low, height }),
      drawn("path", { class: "ticks", d: ticks() }),
      aim,
      needle,
    );
    return { aim, needle };
  }
}
