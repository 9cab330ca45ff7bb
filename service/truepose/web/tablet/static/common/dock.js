// The six buttons that are at the same place on every screen.

import { element, write } from "./elements.js";
import { buttonShape } from "./shapes.js";
import { can, stepOf } from "./situation.js";

const BUTTONS = [
  ["back", "dock.back"],
  ["retry", "dock.retry"],
  ["skip", "dock.skip"],
  ["pause", "dock.pause"],
  ["abort", "dock.abort"],
  ["stop", "dock.stop"],
];
const RESUME = "dock.resume";

export class Dock {
  #buttons;

  // `tapped(act)` is called with what the button means now.
  constructor(nav, tapped) {
    this.#buttons = BUTTONS.map(([act, key]) => {
      const label = element("span");
      const button = element("button", { type: "button", class: `control ${act}`, "data-act": act }, buttonShape(act), label);
      button.addEventListener("click", () => tapped(button.dataset.act));
      nav.append(button);
      return { act, key, label, button };
    });
  }

  show(model, texts) {
    for (const { act, key, label, button } of this.#buttons) {
      const now = act === "pause" && model.session?.state === "paused" ? "resume" : act;
      if (button.dataset.act !== now) button.replaceChild(buttonShape(now), button.firstChild);
      button.dataset.act = now;
      button.disabled = !can(model, now);
      button.classList.toggle("waiting", model.session !== null && model.queue.holds(now, stepOf(model.session, now)));
      write(label, texts.say(now === "resume" ? RESUME : key));
    }
  }
}
