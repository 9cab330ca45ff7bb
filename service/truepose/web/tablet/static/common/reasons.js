// Why nothing goes on, in the language of the page: what the service says most often, by its own sentence.
// What it says of a device, or of what a person wrote, stays as it is.

const SAID = {
  "A pause was asked for.": null, // the title says so
  "Stop was pressed.": "reason.stop",
  "The service was started anew.": "reason.restarted",
};

// Returns { text, lang }, or null where the screen says it all.
export function reasonInWords(reason, texts) {
  const known = Object.keys(SAID).find((sentence) => reason.startsWith(sentence));
  if (known === undefined) return reason ? { text: reason, lang: "en" } : null;
  const more = reason.slice(known.length).trim();
  const said = [SAID[known] && texts.say(SAID[known]), more].filter(Boolean).join(" ");
  return said ? { text: said, lang: texts.language } : null;
}
