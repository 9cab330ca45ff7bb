// Taps that have not been answered yet, in order, kept on the tablet until they are.

export class Queue {
  #storage;
  #name;

  constructor(storage, session) {
    this.#storage = storage;
    this.#name = `truepose.taps.${session}`;
  }

  get taps() {
    const kept = this.#storage.get(this.#name);
    return kept ? JSON.parse(kept) : [];
  }

  // Says whether the tap outlives the page. The same tap at the same step is one tap.
  add(tap) {
    if (this.holds(tap.act, tap.step_id)) return true;
    return this.#keep([...this.taps, tap]);
  }

  remove(key) {
    this.#keep(this.taps.filter((tap) => tap.key !== key));
  }

  holds(act, step_id) {
    return this.taps.some((tap) => tap.act === act && tap.step_id === step_id);
  }

  #keep(taps) {
    return this.#storage.set(this.#name, JSON.stringify(taps));
  }
}
