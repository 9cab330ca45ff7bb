// The one catalogue of what the pages say, and numbers and times as each language writes them.

import { Units } from "/static/units.js";
import { answerTo, ask } from "./api.js";

const KEPT = "truepose.language";
const RECORDS = "en"; // what goes into the records is in one language, whoever tapped

// `rooms`: whose texts a page uses.
async function catalogue(language, rooms) {
  const parts = rooms.map((room) => answerTo(() => ask(`/static/tablet/${room}/${language}.json`, { cache: "default" })));
  return Object.assign({}, ...(await Promise.all(parts)));
}

function choosable() {
  return [...document.getElementById("language").options].map((option) => option.value);
}

export class Texts {
  #catalogues = {};
  #chosen = null;
  #storage;
  #rooms;

  constructor(storage, rooms, preferred) {
    this.units = new Units();
    this.#storage = storage;
    this.#rooms = rooms;
    const wanted = storage.get(KEPT) ?? preferred.slice(0, 2).toLowerCase();
    this.language = choosable().includes(wanted) ? wanted : RECORDS;
  }

  // The other languages follow behind the page: choosing one of them must not need a connection.
  static async load(storage, rooms = ["common"]) {
    const texts = new Texts(storage, rooms, navigator.language ?? RECORDS);
    await Promise.all([RECORDS, texts.language].map((language) => texts.#fetch(language)));
    for (const language of choosable()) texts.#fetch(language).catch(() => {});
    return texts;
  }

  async #fetch(language) {
    this.#catalogues[language] ??= await catalogue(language, this.#rooms);
  }

  // The one chosen last, as soon as it is here.
  async choose(language) {
    this.#chosen = language;
    await this.#fetch(language).catch(() => {});
    if (this.#chosen !== language || !this.#catalogues[language]) return;
    this.language = language;
    this.#storage.set(KEPT, language);
  }

  say(key, values = {}) {
    return this.#filled(this.#catalogues[this.language][key], values);
  }

  list(values) {
    return values.join(this.say("list.between"));
  }

  record(key) {
    return this.#catalogues[RECORDS][key];
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
    document.getElementById("language").value = this.language;
    for (const node of root.querySelectorAll("[data-text]")) node.textContent = this.say(node.dataset.text);
    for (const node of root.querySelectorAll("[data-label]"))
      node.setAttribute("aria-label", this.say(node.dataset.label));
  }

  #filled(text, values) {
    return text.replace(/\{(\w+)\}/g, (_, name) => values[name]);
  }
}
