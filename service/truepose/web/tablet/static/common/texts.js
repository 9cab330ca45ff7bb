// The one catalogue of what the pages say, and numbers and times as each language writes them.

const LANGUAGES = ["en", "fr"];
const KEPT = "truepose.language";

// `rooms`: whose texts a page uses.
async function catalogue(language, rooms) {
  const replies = await Promise.all(rooms.map((room) => fetch(`/static/tablet/${room}/${language}.json`)));
  return Object.assign({}, ...(await Promise.all(replies.map((reply) => reply.json()))));
}

export class Texts {
  #catalogues;
  #storage;

  constructor(catalogues, storage, preferred) {
    this.#catalogues = catalogues;
    this.#storage = storage;
    const wanted = storage.get(KEPT) ?? preferred.slice(0, 2).toLowerCase();
    this.language = LANGUAGES.includes(wanted) ? wanted : "en";
  }

  // All languages are fetched at once: switching must not need a connection.
  static async load(storage, rooms = ["common"]) {
    const loaded = await Promise.all(LANGUAGES.map((language) => catalogue(language, rooms)));
    const catalogues = Object.fromEntries(LANGUAGES.map((language, i) => [language, loaded[i]]));
    return new Texts(catalogues, storage, navigator.language ?? "en");
  }

  switchLanguage() {
    this.language = LANGUAGES.find((language) => language !== this.language);
    this.#storage.set(KEPT, this.language);
  }

  say(key, values = {}) {
    return this.#filled(this.#catalogues[this.language][key], values);
  }

  // What goes into the records is in one language, whoever tapped.
  record(key) {
    return this.#catalogues.en[key];
  }

  number(value, digits) {
    const format = { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false };
    return value.toLocaleString(this.language, format);
  }

  // Without a sign before a zero.
  whole(value) {
    const rounded = Math.round(value);
    return rounded < 0 ? this.signed(rounded, 0) : this.number(Math.abs(rounded), 0);
  }

  signed(value, digits) {
    return `${value < 0 ? "−" : "+"}${this.number(Math.abs(value), digits)}`;
  }

  duration(seconds) {
    const minutes = Math.max(1, Math.round(seconds / 60));
    if (minutes < 60) return this.say("time.minutes", { minutes });
    return this.say("time.hours", { hours: Math.floor(minutes / 60), minutes: minutes % 60 });
  }

  // Fills in what the page itself says.
  translate(root) {
    document.documentElement.lang = this.language;
    for (const node of root.querySelectorAll("[data-text]")) node.textContent = this.say(node.dataset.text);
    for (const node of root.querySelectorAll("[data-label]"))
      node.setAttribute("aria-label", this.say(node.dataset.label));
  }

  #filled(text, values) {
    return text.replace(/\{(\w+)\}/g, (_, name) => values[name]);
  }
}
