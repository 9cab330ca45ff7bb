// The live stream of a session, and the knowledge whether it lives.
//
// It is read with fetch, not EventSource: whatever arrives is a sign of life, comments too, and a stream that
// fell silent without an end (Wi-Fi gone, lid closed) can be given up at once.

import { hear } from "/static/service-time.js";
import { inItsWords } from "/static/words.js";

const SILENCE_MS = 1600; // the service is heard every second; the banner is due within 2 s
const LOOK_MS = 150;
const OPENING_MS = 2500;
const AGAIN_MS = 500;

// Collects bytes as text and yields the events that are complete.
export class EventReader {
  #decoder = new TextDecoder();
  #rest = "";

  *read(bytes) {
    this.#rest += this.#decoder.decode(bytes, { stream: true });
    const blocks = this.#rest.split(/\r?\n\r?\n/);
    this.#rest = blocks.pop();
    for (const block of blocks) {
      const fields = block.split(/\r?\n/).map((line) => /^(\w+): ?(.*)$/.exec(line));
      const all = (name) => fields.filter((field) => field?.[1] === name).map((field) => field[2]);
      if (all("data").length) yield { event: all("event")[0] ?? "message", data: all("data").join("\n") };
    }
  }
}

export class Live {
  #url;
  #on;
  #attempt = new AbortController();
  #heard_ms = 0;
  #began_ms = 0;
  #again = () => {};
  #inOtherWords = false;

  // `on`: { state(up), events by name }
  constructor(url, on) {
    this.#url = url;
    this.#on = on;
    this.up = false;
  }

  open() {
    setInterval(() => this.#look(), LOOK_MS);
    window.addEventListener("offline", () => this.#giveUp());
    window.addEventListener("online", () => this.#again());
    this.#keepReading();
  }

  // The page is read in another language or other units from now on: no link is lost.
  inOtherWords() {
    this.#inOtherWords = this.up;
    if (this.up) this.#attempt.abort();
  }

  // What was received before the tablet slept says nothing of now.
  restart() {
    this.#giveUp();
    this.#again();
  }

  async #keepReading() {
    for (;;) {
      await this.#read().catch(() => null);
      if (this.#inOtherWords) {
        this.#inOtherWords = false;
        continue;
      }
      this.#tell(false);
      await new Promise((resolve) => {
        this.#again = resolve;
        setTimeout(resolve, AGAIN_MS);
      });
    }
  }

  async #read() {
    this.#attempt = new AbortController();
    this.#began_ms = performance.now();
    const reply = hear(await fetch(this.#url, inItsWords({ cache: "no-store", signal: this.#attempt.signal })));
    if (!reply.ok) return;
    const reader = reply.body.getReader();
    const events = new EventReader();
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
      this.#heard_ms = performance.now();
      this.#tell(true);
      for (const { event, data } of events.read(part.value)) this.#on[event]?.(JSON.parse(data));
    }
  }

  #look() {
    const now_ms = performance.now();
    const silent = now_ms - this.#heard_ms > SILENCE_MS;
    if (this.up && silent) this.#giveUp();
    else if (!this.up && silent && now_ms - this.#began_ms > OPENING_MS) this.#attempt.abort();
  }

  #giveUp() {
    this.#tell(false);
    this.#attempt.abort();
  }

  #tell(up) {
    if (this.up === up) return;
    this.up = up;
    this.#on.state(up);
  }
}
