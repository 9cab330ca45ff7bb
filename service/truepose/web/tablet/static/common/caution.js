// What the program cannot do once the arm moves, beside the button that lets it.

import { element, showIf } from "./elements.js";
import { cautionShape } from "./shapes.js";

// The first sentence stands out: it is the one that counts in danger.
function inTwo(notice) {
  const [, first, rest] = /^(.+?[.。])\s*(.*)$/s.exec(notice) ?? [null, notice, ""];
  return element("p", {}, element("strong", {}, first), " ", rest);
}

export class Caution {
  #place;
  #shown = null;

  constructor(place) {
    this.#place = place;
  }

  // `moves`: the screen has a button that lets the arm move.
  show(moves, session) {
    const notice = moves ? (session?.motion_notice ?? null) : null;
    showIf(this.#place, notice !== null);
    if (notice === null || notice === this.#shown) return;
    this.#shown = notice;
    this.#place.replaceChildren(cautionShape(), inTwo(notice));
  }
}
