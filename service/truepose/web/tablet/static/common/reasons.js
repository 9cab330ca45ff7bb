// Why nothing goes on, in the language of the page as far as the service's sentences are known. What it says of a
// device, or of what a person wrote, stays as it is.

import { element } from "./elements.js";

const TITLED = "A pause was asked for."; // the title says so

// Returns a paragraph, or null where the screen says it all.
export function reasonInWords(reason, texts) {
  const more = reason.startsWith(TITLED) ? reason.slice(TITLED.length).trim() : reason;
  return more ? element("p", { class: "reason" }, ...inWords(more, texts)) : null;
}

// A kept text as pieces, each marked with its language.
export function inWords(text, texts) {
  return texts.pieces(text).flatMap((piece, n) => [n ? " " : null, element("span", { lang: piece.lang }, piece.text)]);
}
