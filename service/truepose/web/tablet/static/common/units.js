// In which unit a tablet shows lengths: millimetres or inches. What is kept is always in millimetres.

const KEPT = "truepose.units";
const INCH_MM = 25.4;
const UNITS = {
  mm: { per_mm: 1, key: "unit.mm", digits: { fine: 3, coarse: 1 } },
  inch: { per_mm: 1 / INCH_MM, key: "unit.inch", digits: { fine: 5, coarse: 2 } },
};

export class Units {
  #storage;

  constructor(storage) {
    this.#storage = storage;
    this.name = storage.get(KEPT) in UNITS ? storage.get(KEPT) : "mm";
  }

  switch() {
    this.name = Object.keys(UNITS).find((name) => name !== this.name);
    this.#storage.set(KEPT, this.name);
  }

  unit(texts) {
    return texts.say(UNITS[this.name].key);
  }

  // A number without its unit, for columns whose head names it; `how`: fine or coarse.
  number(length_mm, texts, how = "fine") {
    const { per_mm, digits } = UNITS[this.name];
    return texts.number(length_mm * per_mm, digits[how]);
  }

  signed(length_mm, texts, how = "fine") {
    const { per_mm, digits } = UNITS[this.name];
    const shown = Number((length_mm * per_mm).toFixed(digits[how]));
    return shown === 0 ? texts.number(0, digits[how]) : texts.signed(shown, digits[how]); // no sign before a zero
  }

  length(length_mm, texts, how = "fine") {
    return texts.say("unit.with", { value: this.number(length_mm, texts, how), unit: this.unit(texts) });
  }

  // Small ones, of drift and scatter: micrometres, or inches with all their digits.
  small(length_mm, texts) {
    if (this.name !== "mm") return this.length(length_mm, texts);
    return texts.say("unit.with", { value: texts.number(1000 * length_mm, 0), unit: texts.say("unit.um") });
  }
}
