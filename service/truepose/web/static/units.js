// In which units numbers are shown: one choice for this browser, on the service's pages and on a tablet's.
// What is kept and sent stays in mm, degrees and °C.

const COOKIE = "units"; // as the pages have it: `inch-deg-c`
const YEAR_S = 365 * 24 * 3600;
const MM_IN = 25.4;
const KINDS = [["mm", "inch"], ["deg", "rad"], ["c", "f"]]; // kept in the first
const SHOWN = {
  inch: { mm: { symbol: "in", factor: 1 / MM_IN }, "µm": { symbol: "in", factor: 0.001 / MM_IN } },
  rad: { "°": { symbol: "rad", factor: Math.PI / 180 } },
  f: { "°C": { symbol: "°F", factor: 1.8, offset: 32 } },
};
const DIGITS = { fine: 3, coarse: 1 }; // of a length in mm

function kept() {
  const said = document.cookie.split("; ").find((one) => one.startsWith(`${COOKIE}=`));
  return said ? said.slice(COOKIE.length + 1).split("-") : [];
}

export class Units {
  constructor(chosen = kept()) {
    this.chosen = KINDS.map((known) => known.find((token) => chosen.includes(token)) ?? known[0]);
  }

  // For whoever draws only what is new.
  get name() {
    return this.chosen.join("-");
  }

  // The other unit of lengths, from now on.
  switch() {
    const [known] = KINDS;
    this.chosen[0] = known.find((token) => token !== this.chosen[0]);
    document.cookie = `${COOKIE}=${this.name}; path=/; max-age=${YEAR_S}; samesite=lax`;
  }

  symbol(unit) {
    return this.#conversion(unit).symbol;
  }

  // A kept value, and the digits that show it no coarser than it was kept with.
  shown(value, unit, digits) {
    const { factor, offset } = this.#conversion(unit);
    return { value: factor * value + offset, digits: digits + Math.max(0, Math.ceil(-Math.log10(factor))) };
  }

  quantity(value, unit, digits, texts) {
    const shown = this.shown(value, unit, digits);
    return this.#with(texts.number(shown.value, shown.digits), unit);
  }

  // A length without its unit, for columns whose head names it; `how`: fine or coarse.
  number(length_mm, texts, how = "fine") {
    const { value, digits } = this.shown(length_mm, "mm", DIGITS[how]);
    return texts.number(value, digits);
  }

  signed(length_mm, texts, how = "fine") {
    const { value, digits } = this.shown(length_mm, "mm", DIGITS[how]);
    const rounded = Number(value.toFixed(digits));
    return rounded === 0 ? texts.number(0, digits) : texts.signed(rounded, digits); // no sign before a zero
  }

  length(length_mm, texts, how = "fine") {
    return this.#with(this.number(length_mm, texts, how), "mm");
  }

  difference(length_mm, texts) {
    return this.#with(this.signed(length_mm, texts), "mm");
  }

  // Small ones, of drift and scatter: micrometres, or inches with all their digits.
  small(length_mm, texts) {
    return this.quantity(1000 * length_mm, "µm", 0, texts);
  }

  #with(number, unit) {
    const symbol = this.symbol(unit);
    return symbol === "°" ? `${number}°` : `${number} ${symbol}`;
  }

  #conversion(unit) {
    const token = this.chosen.find((one) => SHOWN[one]?.[unit]);
    return { symbol: unit, factor: 1, offset: 0, ...SHOWN[token]?.[unit] };
  }
}

// A number as the language of the page writes it, where no catalogue is at hand.
export const numbers = {
  number: (value, digits) => {
    const format = { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false };
    return value.toLocaleString(document.documentElement.lang, format);
  },
};
