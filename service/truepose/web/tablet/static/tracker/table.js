// Nominal, actual and difference of every configuration; the present one is followed, any one can be chosen.

import { element } from "../common/elements.js";

const STATUS = { open: "table.open", measured: "table.measured", failed: "table.failed", left_out: "table.left_out" };
const MARKS = { open: "·", measured: "✓", failed: "✕", left_out: "–" };
const FOLLOWED_MS = 15000; // whoever scrolls looks at something: the table does not run away meanwhile

export class Table {
  #place;
  #on;
  #shown = "";
  #rows = new Map();
  #scrolled_ms = -Infinity;
  chosen = null; // configuration

  // `on`: { chosen() }
  constructor(place, on) {
    this.#place = place;
    this.#on = on;
    for (const name of ["wheel", "touchmove", "keydown"])
      place.addEventListener(name, () => (this.#scrolled_ms = performance.now()), { passive: true });
  }

  show(points, active, { texts, units }) {
    const shown = JSON.stringify([points, texts.language, units.name]);
    if (shown !== this.#shown) this.#build(points, texts, units);
    this.#shown = shown;
    for (const [config, row] of this.#rows) {
      row.classList.toggle("active", config === active);
      row.classList.toggle("chosen", config === this.chosen);
      row.querySelector("button").setAttribute("aria-pressed", config === this.chosen);
    }
    if (performance.now() - this.#scrolled_ms > FOLLOWED_MS && this.chosen === null) this.#follow(active);
  }

  #follow(active) {
    const row = this.#rows.get(active);
    if (!row || !this.#place.clientHeight) return;
    const top = row.offsetTop - (this.#place.clientHeight - row.offsetHeight) / 2;
    if (Math.abs(this.#place.scrollTop - top) > row.offsetHeight) this.#place.scrollTop = top;
  }

  #build(points, texts, units) {
    const unit = units.symbol("mm");
    const gauges = points.some((point) => point.reading_mm.length > 0) || points.every((point) => point.expected_mm === null);
    const columns = gauges ? gaugeColumns(texts, units) : pointColumns(texts, units);
    const head = element("tr", {}, ...columns.map(({ head, kind }) => element("th", { scope: "col", class: kind }, head)));
    this.#rows = new Map(points.map((point) => [point.config, this.#row(point, columns, texts)]));
    const caption = element("caption", {}, texts.say("table.caption", { unit }));
    this.#place.replaceChildren(element("table", {}, caption, element("thead", {}, head), element("tbody", {}, ...this.#rows.values())));
  }

  #row(point, columns, texts) {
    const [, ...rest] = columns;
    const name = texts.say("table.row", { config: point.config, status: texts.say(STATUS[point.status]) });
    const button = element("button", { type: "button", class: "pick", "aria-label": name, onclick: () => this.#choose(point.config) },
      element("b", {}, String(point.config)), element("span", { "aria-hidden": "true" }, MARKS[point.status]));
    const cells = rest.map(({ cell, kind }) => element("td", { class: kind }, cell(point)));
    return element("tr", { "data-status": point.status }, element("th", { scope: "row" }, button), ...cells);
  }

  #choose(config) {
    this.chosen = this.chosen === config ? null : config;
    this.#on.chosen();
  }
}

// Why it is as it is, where there is a reason.
function state({ reason, status }, texts) {
  return reason || texts.say(STATUS[status]);
}

function pointColumns(texts, units) {
  const three = (values, format) => (values ? values.map(format).join("  ") : "");
  const maybe = (value, format) => (value === null ? "" : format(value));
  const plain = (value) => units.number(value, texts, "coarse");
  const fine = (value) => units.number(value, texts);
  return [
    { head: texts.say("table.number") },
    { head: texts.say("table.nominal"), kind: "places", cell: (point) => three(point.expected_mm, plain) },
    { head: texts.say("table.actual"), kind: "places", cell: (point) => three(point.actual_mm, plain) },
    { head: texts.say("table.delta"), kind: "differences", cell: (point) => three(point.delta_mm, (value) => units.signed(value, texts)) },
    { head: texts.say("table.distance"), kind: "distances", cell: (point) => maybe(point.distance_mm, fine) },
    { head: texts.say("table.rms"), kind: "scatters", cell: (point) => scatter(point, texts, units) },
    { head: texts.say("table.readings"), kind: "passes", cell: (point) => (point.readings ? String(point.readings) : "") },
    { head: texts.say("table.state"), cell: (point) => state(point, texts) },
  ];
}

// The scatter of the samples, against what the instrument is allowed.
function scatter({ rms_mm, rms_limit_mm }, texts, units) {
  if (rms_mm === null) return "";
  return texts.say("table.of_limit", { rms: units.number(rms_mm, texts), limit: units.number(rms_limit_mm, texts, "fine") });
}

function gaugeColumns(texts, units) {
  return [
    { head: texts.say("table.number") },
    { head: texts.say("table.gauges"), kind: "distances", cell: (point) => point.reading_mm.map((value) => units.signed(value, texts)).join("  ") },
    { head: texts.say("table.state"), cell: (point) => state(point, texts) },
  ];
}
