// What the states sound and feel like. A person connects the bar with both hands and looks at it, not at the tablet.

const TONES = {
  in_range: [[660, 0, 0.09], [880, 0.11, 0.14]],
  out_low: [[220, 0, 0.16], [165, 0.2, 0.22]],
  out_high: [[740, 0, 0.12], [988, 0.16, 0.12], [988, 0.32, 0.12]],
  unstable: [[440, 0, 0.06]],
  no_signal: [[130, 0, 0.25]],
  stored: [[784, 0, 0.1], [988, 0.1, 0.1], [1319, 0.2, 0.28]],
  doubt: [[523, 0, 0.18], [415, 0.2, 0.18], [523, 0.4, 0.18], [415, 0.6, 0.3]],
  move: [[392, 0, 0.2], [392, 0.3, 0.2], [392, 0.6, 0.2]],
  lost: [[330, 0, 0.2], [220, 0.25, 0.4]],
};
const SHAKES_MS = { stored: [80], doubt: [200, 100, 200], lost: [400] }; // where a tablet can
const LOUDNESS = 0.22;
const LOWEST_HZ = 220;
const OCTAVES = 3;
const SETTLED_MS = 350; // a state that passes by makes no noise

export class Sound {
  #context = null;
  #muted;
  #pending = null;
  #state = null;

  constructor(muted) {
    this.#muted = muted;
    // Browsers let a page sound only after it was touched.
    for (const name of ["pointerdown", "keydown"])
      document.addEventListener(name, () => this.#unlock(), { capture: true });
  }

  play(name) {
    if (this.#muted() || this.#context?.state !== "running") return;
    if (SHAKES_MS[name]) navigator.vibrate?.(SHAKES_MS[name]);
    for (const [frequency_hz, start_s, length_s] of TONES[name]) this.#tone(frequency_hz, start_s, length_s);
  }

  // A short tone whose pitch says how near something is: `share` from 0, far, to 1, there.
  near(share) {
    if (this.#muted() || this.#context?.state !== "running") return;
    this.#tone(LOWEST_HZ * 2 ** (OCTAVES * share), 0, 0.08);
  }

  // Plays a state of the length once it has lasted.
  state(name) {
    if (name === this.#state) return;
    this.#state = name;
    clearTimeout(this.#pending);
    if (name !== null) this.#pending = setTimeout(() => this.play(name), SETTLED_MS);
  }

  #unlock() {
    this.#context ??= new AudioContext();
    if (this.#context.state === "suspended") this.#context.resume();
  }

  #tone(frequency_hz, start_s, length_s) {
    const begin = this.#context.currentTime + start_s;
    const oscillator = new OscillatorNode(this.#context, { frequency: frequency_hz, type: "triangle" });
    const gain = new GainNode(this.#context, { gain: 0 });
    gain.gain.setValueAtTime(0, begin);
    gain.gain.linearRampToValueAtTime(LOUDNESS, begin + 0.01);
    gain.gain.setTargetAtTime(0, begin + length_s * 0.6, length_s * 0.2);
    oscillator.connect(gain).connect(this.#context.destination);
    oscillator.start(begin);
    oscillator.stop(begin + length_s * 1.6);
  }
}
