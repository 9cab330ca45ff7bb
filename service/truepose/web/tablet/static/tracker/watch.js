// The watch window: how far the reflector is from where it is expected, large enough to be read from the nest.

import { write } from "../common/elements.js";
import { stateShape } from "../common/shapes.js";

const WORDS = { within: "watch.within", near: "watch.near", far: "watch.far", no_signal: "watch.no_signal" };
const FAR_MM = 100; // from which on nobody looks at micrometres
const SHAPES = { within: "in_range", near: "unstable", far: "out_high", no_signal: "no_signal" };

export class Watch {
  #at;
  #state = null;

  constructor(at) {
    this.#at = at;
  }

  // `sample`: null where nothing was received; `searching`: the fixed nests are looked for.
  show(sample, { texts, units, up, searching }) {
    const state = (up && sample?.state) || "no_signal";
    this.#showState(state, texts);
    write(this.#at.aim, this.#aimed(sample, searching, texts));
    const how = sample?.distance_mm >= FAR_MM ? "coarse" : "fine";
    write(this.#at.distance, this.#number(sample?.distance_mm, (value) => units.length(value, texts, how)));
    for (const [i, name] of ["dx", "dy", "dz"].entries())
      write(this.#at[name], this.#number(sample?.delta_mm?.[i], (value) => units.signed(value, texts, how)));
    write(this.#at.advice, this.#advice(sample, state, texts, units, up));
    // For whoever measures how old the number on the screen is.
    this.#at.watch.dataset.sampledAtMs = sample?.sampled_at_ms ?? "";
  }

  #showState(state, texts) {
    write(this.#at.word, texts.say(WORDS[state]));
    if (state === this.#state) return;
    this.#state = state;
    this.#at.watch.dataset.state = state;
    this.#at.shape.replaceChildren(stateShape(SHAPES[state]));
  }

  #aimed(sample, searching, texts) {
    if (sample?.fixed_nest) return texts.say("watch.fixed_nest", { nest: sample.fixed_nest });
    if (sample?.config) return texts.say("watch.tool_nest", { nest: sample.nest, config: sample.config });
    return texts.say(searching ? "watch.searching" : "watch.nothing");
  }

  #number(value, format) {
    return value === null || value === undefined ? "– – –" : format(value);
  }

  #advice(sample, state, texts, units, up) {
    if (!up) return texts.say("advice.offline");
    if (!sample || sample.tolerance_mm === null) return texts.say("watch.waits");
    if (sample.is_moving) return texts.say("watch.on_the_way");
    const tolerance = units.length(sample.tolerance_mm, texts, sample.tolerance_mm < 1 ? "fine" : "coarse");
    if (state !== "no_signal") return texts.say("watch.tolerance", { tolerance });
    return sample.fixed_nest ? texts.say("watch.catch_fixed", { nest: sample.fixed_nest }) : texts.say("watch.catch_tool", { nest: sample.nest });
  }
}
