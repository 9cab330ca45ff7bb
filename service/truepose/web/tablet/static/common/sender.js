// Sends taps to the service: queued ones in order and once each, motion only while somebody looks.

import { Refused, post } from "./api.js";
import { now_s } from "/static/service-time.js";
import { newKey } from "./tablet.js";

const AGAIN_MS = 1000;
const MOTION_PATIENCE_MS = 2000; // what is confirmed now must not happen later

function body({ key, act, ...rest }) {
  return { command: act, ...rest };
}

export class Sender {
  #path;
  #queue;
  #on;
  #sending = false;

  // `path`: of the session; `on`: { changed(), answered(session), dropped(tap, error), unreached(tap) }
  constructor(path, queue, on) {
    this.#path = `${path}/commands`;
    this.#queue = queue;
    this.#on = on;
  }

  // Keeps the tap, then sends what is kept.
  queue(tap) {
    const kept = this.#queue.add({ key: newKey(), ...tap, pressed_at_s: now_s() });
    this.#on.changed();
    this.flush();
    return kept;
  }

  // Sends now or never.
  async now(tap) {
    try {
      const answer = await post(this.#path, { ...body(tap), pressed_at_s: now_s() }, newKey(), MOTION_PATIENCE_MS);
      this.#on.answered(answer.session);
    } catch (error) {
      if (error instanceof Refused) this.#on.dropped(tap, error);
      else this.#on.unreached(tap);
    }
  }

  async flush() {
    if (this.#sending) return;
    this.#sending = true;
    try {
      for (let [tap] = this.#queue.taps; tap; [tap] = this.#queue.taps) await this.#send(tap);
    } catch {
      // Not reached: the tap stays first in the queue, and its key makes a second arrival harmless.
      setTimeout(() => this.flush(), AGAIN_MS);
    } finally {
      this.#sending = false;
      this.#on.changed();
    }
  }

  async #send(tap) {
    try {
      const answer = await post(this.#path, body(tap), tap.key);
      this.#queue.remove(tap.key);
      this.#on.answered(answer.session);
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.#queue.remove(tap.key);
      await this.#on.dropped(tap, error);
    }
  }
}
