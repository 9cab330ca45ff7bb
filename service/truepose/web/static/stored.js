// Sentences that the service keeps in English, in the language of the page: as `words/heard.py` takes them apart.
// What is not among them, such as the words of a driver or of a person, stays as it is.

const RECORDS = "en";
const BLANK = /\{(\w+)\}/;
const END = /(?<=[.?!])\s+|$/g; // of a sentence
const SENTENCES = "sentence"; // a blank that holds whole ones

const escaped = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
const plain = (text) => text.split(BLANK).filter((_, n) => n % 2 === 0).join("").length;

function pattern([key, text]) {
  const parts = text.split(BLANK);
  const source = parts.map((part, n) => (n % 2 === 0 ? escaped(part) : part === SENTENCES ? "(.+?[.?!])" : "(.+?)")).join("");
  return { key, names: parts.filter((_, n) => n % 2 === 1), known: new RegExp(`^${source}$`, "s") };
}

export class Stored {
  #patterns;
  #mine;
  #language;

  static NONE = new Stored({}, {}, RECORDS); // knows no sentence

  // `english` and `mine`: texts by key, in the language of records and in the reader's.
  constructor(english, mine, language) {
    this.#patterns = Object.entries(english).sort(([, a], [, b]) => plain(b) - plain(a)).map(pattern);
    this.#mine = mine;
    this.#language = language;
  }

  // Both from the service; where they cannot be had now, everything stays as it is.
  static async load(language) {
    if (language === RECORDS) return Stored.NONE;
    const texts = (of) => fetch(`/static/tablet/stored/${of}.json`).then((reply) => reply.json());
    const [english, mine] = await Promise.all([RECORDS, language].map(texts)).catch(() => [{}, {}]);
    return new Stored(english, mine, language);
  }

  // Returns the sentences of a text, each { text, lang }.
  pieces(text) {
    if (!this.#patterns.length) return text ? [{ text, lang: RECORDS }] : [];
    const ends = [...text.matchAll(END)].map(({ index }) => index);
    const after = (end) => end + (text.slice(end).length - text.slice(end).trimStart().length);
    const found = [];
    const add = (from, to) => to > from && found.push({ text: text.slice(from, to).trimEnd(), lang: RECORDS });
    let begin = 0;
    let unknown = 0;
    while (begin < text.length) {
      const later = ends.filter((end) => end > begin);
      let said = null; // kept: what is in a sentence may be sentences, and to say them twice would double at each depth
      const end = later.findLast((one) => (said = this.#said(text.slice(begin, one))) !== null);
      if (end !== undefined) {
        add(unknown, begin);
        found.push({ text: said, lang: this.#language });
      }
      begin = after(end ?? later[0]);
      if (end !== undefined) unknown = begin;
    }
    add(unknown, text.length);
    return found;
  }

  // A known sentence in the reader's language; null where it is not known.
  #said(text) {
    for (const { key, names, known } of this.#patterns) {
      const match = known.exec(text);
      if (match) {
        const values = Object.fromEntries(names.map((name, n) => [name, this.#value(match[n + 1])]));
        return this.#mine[key].replace(/\{(\w+)\}/g, (_, name) => values[name]);
      }
    }
    return null;
  }

  #value(text) {
    return this.pieces(text).map((piece) => piece.text).join(" ");
  }
}
