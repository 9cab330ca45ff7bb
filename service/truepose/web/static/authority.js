// Who acts in a session: renewed while this page is open, and taken over by whoever says so.

const RENEWED_MS = 5000; // it lasts 15 s

async function asked(path, method, body) {
  const request = { method, cache: "no-store", headers: { "Content-Type": "application/json" } };
  const reply = await fetch(path, body ? { ...request, body: JSON.stringify(body) } : request).catch(() => null);
  const answer = await reply?.json().catch(() => null);
  return reply?.ok ? [answer, null] : [null, answer];
}

export class Authority {
  #path;
  #changed;

  // `changed`: told who acts, whenever it was looked at.
  constructor(session, changed) {
    this.#path = `/api/v1/sessions/${session}/authority`;
    this.#changed = changed;
  }

  keep() {
    setInterval(() => document.hidden || this.look(), RENEWED_MS);
    this.look();
  }

  async look() {
    let [held] = await asked(this.#path, "GET");
    if (held?.mine) [held] = await asked(this.#path, "PUT", {});
    if (held) this.#changed(held);
  }

  // Returns whether it is taken, and what was refused; neither where nobody answered.
  async takeOver() {
    const [held, problem] = await asked(this.#path, "PUT", { take_over: true });
    if (held) this.#changed(held);
    return [held !== null, problem];
  }
}
