// What this tablet keeps for itself: its number, the person's name, whether it is silent.

const NUMBER = "truepose.tablet";
const PERSON = "truepose.person";
const MUTED = "truepose.muted";

// A tablet may forbid its pages to keep anything; then they work until they are closed.
export class Storage {
  #fallback = new Map();

  get(name) {
    try {
      return localStorage.getItem(name) ?? this.#fallback.get(name) ?? null;
    } catch {
      return this.#fallback.get(name) ?? null;
    }
  }

  // Says whether it is kept beyond the life of the page.
  set(name, value) {
    this.#fallback.set(name, value);
    try {
      localStorage.setItem(name, value);
      return true;
    } catch {
      return false;
    }
  }
}

// `crypto.randomUUID` exists on encrypted pages only; a shop's network serves plain ones.
export function newKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

export class Tablet {
  #storage;

  constructor(storage) {
    this.#storage = storage;
    this.id = storage.get(NUMBER) ?? `tablet-${newKey().slice(0, 12)}`;
    storage.set(NUMBER, this.id);
  }

  get person() {
    return this.#storage.get(PERSON);
  }

  set person(name) {
    this.#storage.set(PERSON, name);
  }

  get muted() {
    return this.#storage.get(MUTED) === "yes";
  }

  set muted(muted) {
    this.#storage.set(MUTED, muted ? "yes" : "no");
  }
}
