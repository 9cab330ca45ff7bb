// The simulated hands: the person's part of a session on a cell where everything is simulated.

import { answerTo, ask, post } from "../common/api.js";
import { element } from "../common/elements.js";

const PATH = "/api/v1/simulated-hands";
const BUTTONS = [
  ["asked", "hands.asked"],
  ["other", "hands.other"],
  ["detach", "hands.detach"],
  ["pull_cable", "hands.pull"],
  ["plug_cable", "hands.plug"],
];
const OFF_MS = 400; // long enough for the service to see that the bar has left its cups
const TAKEN = ["calibrator", "side", "connect"];
const pointNumber = (name) => Number(name.slice(1));

// What a person does when the step asks for it; null where there is nothing to do with the hands.
export function asked(step) {
  const [first, second] = (step.points ?? []).map(pointNumber);
  const { artefact, placement } = step;
  const actions = {
    initialise: { action: "calibrator", bars: artefact },
    measure_side: { action: "side", artefact, a: first, b: second },
    place_base: { action: "place_base", placement },
    fit_ball: { action: "fit_ball" },
    remove_ball: { action: "remove_ball" },
    clamp_cup: { action: "clamp", base_point: step.base_point },
    connect_leg: { action: "connect", base: first, tool: second },
    detach: { action: "detach" },
  };
  return actions[step.kind] ?? null;
}

// Devices say what is wrong in half a sentence.
function asSentence(text) {
  const whole = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?]$/.test(whole) ? whole : `${whole}.`;
}

export class Hands {
  #place;
  #buttons = [];
  #on;

  // `on`: { present(): session or null, pairs(): [base, tool] each, other(chosen), failed(sentence or "") }
  constructor(place, on) {
    this.#place = place;
    this.#on = on;
  }

  // A real cell has none, and its service says so.
  async exist() {
    const found = await answerTo(() => ask(PATH)).catch(() => null);
    return found?.simulated === true;
  }

  show(texts) {
    if (!this.#buttons.length) {
      this.#buttons = BUTTONS.map(([name]) => element("button", { type: "button", "data-hand": name, onclick: () => this.#tap(name) }));
      this.#place.append(...this.#buttons);
    }
    BUTTONS.forEach(([, key], i) => (this.#buttons[i].textContent = texts.say(key)));
    const step = this.#on.present()?.step;
    this.#buttons[0].disabled = !step || !asked(step);
    this.#buttons[1].disabled = !this.#on.pairs().length; // the picture says which there are
  }

  #tap(name) {
    const session = this.#on.present();
    if (name === "asked" && session?.step) this.#do(asked(session.step));
    else if (name === "other") this.#on.other((base, tool) => this.#do({ action: "connect", base, tool }));
    else this.#do({ action: name });
  }

  // As hands do it: the bar comes off where it was before it is put elsewhere.
  async #do(action) {
    try {
      if (TAKEN.includes(action.action)) await this.#takeOff();
      await post(PATH, action);
    } catch (error) {
      this.#on.failed(error.status ? asSentence(error.message) : "");
    }
  }

  async #takeOff() {
    if (!(await ask(PATH)).holding) return;
    await post(PATH, { action: "detach" });
    await new Promise((resolve) => setTimeout(resolve, OFF_MS));
  }
}
