// Whether the ballbar was connected anew since its length was last read: the service stores none twice by itself.

const JUMP_MM = 0.01; // far above the noise of a bar that sits, as the service has it
const AWAY = ["no_signal", "out_low", "out_high"];

export class Connection {
  #read_mm = null; // what was read where the bar sat; null: it was connected anew, or nobody knows
  #last_mm = null;

  get old() {
    return this.#read_mm !== null;
  }

  // A length was stored, or is in doubt.
  read(length_mm) {
    this.#read_mm = length_mm;
  }

  // Taken off, or to be read again where it sits.
  renew() {
    this.#read_mm = null;
  }

  see({ state, length_mm }) {
    const jumped = this.#last_mm !== null && length_mm !== null && Math.abs(length_mm - this.#last_mm) > JUMP_MM;
    if (AWAY.includes(state) || (jumped && Math.abs(length_mm - this.#read_mm) > JUMP_MM)) this.renew();
    this.#last_mm = length_mm;
  }
}
