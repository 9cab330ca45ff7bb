// What the program cannot do once the arm moves, beside the button that lets it: in the language of the page and in
// few words where the service's sentence is known, else as the service says it.

import { element, showIf } from "./elements.js";
import { cautionShape } from "./shapes.js";

const SAID = /^If this program or its connection fails while the arm moves, (.+)\. Only the emergency stop stops the arm at once\.$/;
const ALONE = [
  [/^the controller stops the arm by itself within ([\d.]+) s$/, "caution.stops"],
  [/^the arm goes on for up to ([\d.]+) s, to the end of the piece that was sent$/, "caution.piece"],
  [/^the arm goes on to the target that was sent$/, "caution.target"],
];

function inNumbers(seconds, texts) {
  return texts.number(Number(seconds), (seconds.split(".")[1] ?? "").length);
}

// Returns what the arm does by itself, in few words; null where the sentence is not known.
function aloneInWords(notice, texts) {
  const alone = SAID.exec(notice)?.[1] ?? "";
  const [pattern, key] = ALONE.find(([known]) => known.test(alone)) ?? [];
  if (!key) return null;
  const [, seconds] = pattern.exec(alone);
  return texts.say(key, { seconds: seconds && inNumbers(seconds, texts) });
}

function words(notice, texts) {
  const alone = aloneInWords(notice, texts);
  if (alone === null) return element("p", { lang: "en" }, notice);
  return element("p", {}, element("strong", {}, texts.say("caution.only")), " ", alone);
}

export class Caution {
  #place;
  #shown = null;

  constructor(place) {
    this.#place = place;
  }

  // `moves`: the screen has a button that lets the arm move.
  show(moves, session, texts) {
    const notice = session?.motion_notice;
    const shown = notice && moves ? `${texts.language} ${notice}` : null;
    showIf(this.#place, shown !== null);
    if (shown === null || shown === this.#shown) return;
    this.#shown = shown;
    this.#place.replaceChildren(cautionShape(), words(notice, texts));
  }
}
