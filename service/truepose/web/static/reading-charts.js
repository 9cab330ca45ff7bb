// <reading-charts src="...residuals">: the readings of a result in linked charts and a table. What is hovered or
// picked in one is marked in all.

import { answerTo, answered, filled, onSubmit, post } from "./api.js";
import { dependence } from "./dependence.js";
import { Units, numbers } from "./units.js";

const units = new Units();
const WORST = 12; // readings in the table while none is picked
const MOST_ROWS = 200;
const CLASSES = 40;
const SHOWN_CAUSES = 8;
const ERROR_DIGITS = units.shown(0, "mm", 4).digits; // as many as tell a tenth of a micrometre
const PLANES = { xy: ["x", "y"], xz: ["x", "z"], yz: ["y", "z"] };
const MARK_PX = { least: 1.5, most: 6 };
const KEPT = { deg: "°" }; // units of the API as units.js names them

class ReadingCharts extends HTMLElement {
  async connectedCallback() {
    try {
      const [found, charts] = await Promise.all([
        answerTo(() => answered(this.getAttribute("src"), {}, this.dataset.unreachable)),
        import("/static/chart.js"),
      ]);
      this.begin(found, charts);
    } catch (error) {
      this.part("missing").hidden = false;
      this.part("live").hidden = true;
      console.error(error);
    }
  }

  part(name) {
    return this.querySelector(`[data-part="${name}"]`);
  }

  begin(found, { ScatterChart, Histogram }) {
    this.found = found;
    this.names = JSON.parse(this.dataset.variables);
    this.columns = found.variables.map(({ values, unit }) => inUnits(values, KEPT[unit] ?? unit));
    this.picked = new Set();
    this.hovered = null;
    const told = {
      number: (value, digits) => numbers.number(value, digits),
      hovered: (what) => this.hover(what),
      picked: (which) => this.pick(which),
    };
    this.charts = {
      over: new ScatterChart(this.part("over"), told),
      map: new ScatterChart(this.part("map"), told),
      spread: new Histogram(this.part("spread"), told),
    };
    this.part("shown").querySelectorAll("[data-quantity]").forEach((option) => option.dataset.quantity === found.quantity || option.remove());
    this.fill(this.part("variable"), found.variables.map((one) => this.name(one)));
    this.listen();
    this.show();
    this.dataset.ready = "";
  }

  name({ name, joint }) {
    return filled(this.names[name], { number: joint });
  }

  fill(select, names) {
    select.replaceChildren(...names.map((name, index) => new Option(name, index)));
  }

  listen() {
    for (const name of ["variable", "shown", "plane", "both"]) this.part(name).addEventListener("change", () => this.show());
    this.part("drag").addEventListener("change", ({ target }) => {
      for (const chart of Object.values(this.charts)) chart.drags = target.value;
    });
    this.part("reset").addEventListener("click", () => Object.values(this.charts).forEach((chart) => chart.reset()));
    this.part("none").addEventListener("click", () => this.pick([], false));
    this.part("table").addEventListener("click", ({ target }) => {
      const row = target.closest("tr[data-index]");
      if (row) this.pick([Number(row.dataset.index)]);
    });
    this.part("space").addEventListener("click", () => this.inSpace());
    this.part("csv").addEventListener("click", () => keep(new Blob([this.csv()], { type: "text/csv" }), "readings.csv"));
    this.part("aside")?.addEventListener("click", () => this.askAside());
    this.part("again")?.addEventListener("click", () => this.askAgain());
    for (const button of this.querySelectorAll("[data-close]")) button.addEventListener("click", () => button.closest("dialog").close());
    for (const form of this.querySelectorAll("[data-part=again-dialogue] form")) onSubmit(form, (say) => this.measureAgain(form, say));
    for (const button of this.querySelectorAll("[data-picture]")) button.addEventListener("click", () => this.picture(button.dataset));
    new MutationObserver(() => this.show()).observe(document.documentElement, { attributes: true, attributeFilter: ["data-look"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.show());
  }

  // Errors as they are looked at: their size, or along one direction with its sign.
  errors(name) {
    const along = this.part("shown").value;
    const kept = this.found[`${name}_mm`].map((error) => (along === "size" ? Math.hypot(...error) : error[Number(along)]));
    return inUnits(kept, "mm");
  }

  labelled(index) {
    const variable = this.found.variables[index];
    const unit = variable.unit && units.symbol(KEPT[variable.unit] ?? variable.unit);
    return unit ? `${this.name(variable)} [${unit}]` : this.name(variable);
  }

  show() {
    const [before, after] = [this.errors("before"), this.errors("after")];
    const index = Number(this.part("variable").value);
    const error = `${this.part("shown").selectedOptions[0].text} [${units.symbol("mm")}]`;
    this.after = after;
    this.before = before;
    this.charts.over.show({ x: this.columns[index], y: after, before: this.part("both").checked ? before : [], labels: [this.labelled(index), error] });
    this.charts.spread.show({ before: this.part("both").checked ? before : after, after, classes: CLASSES, labels: [error, this.dataset.count] });
    const [across, up] = PLANES[this.part("plane").value].map((name) => this.found.variables.findIndex((one) => one.name === name));
    this.charts.map.show({ x: this.columns[across], y: this.columns[up], radius: sizes(after), labels: [across, up].map((one) => this.labelled(one)) });
    this.causes(after);
    this.mark();
  }

  // Variables by how much of the errors follows them; a tap draws the errors over one.
  causes(errors) {
    const ranked = this.found.variables
      .map((variable, index) => ({ index, name: this.name(variable), share: dependence(this.columns[index], errors) }))
      .sort((a, b) => b.share - a.share)
      .slice(0, SHOWN_CAUSES);
    this.part("causes").replaceChildren(...ranked.map((one) => this.cause(one)));
  }

  cause({ index, name, share }) {
    const button = document.createElement("button");
    const bar = document.createElement("meter");
    const percent = document.createElement("b");
    Object.assign(bar, { value: share, min: 0, max: 1 });
    percent.textContent = `${numbers.number(100 * share, 0)} %`;
    button.type = "button";
    button.append(Object.assign(document.createElement("span"), { textContent: name }), bar, percent);
    button.addEventListener("click", () => {
      this.part("variable").value = index;
      this.show();
    });
    const item = document.createElement("li");
    item.append(button);
    return item;
  }

  hover(what) {
    this.hovered = typeof what === "number" ? what : null;
    const line = this.part("line");
    if (what === null || what === undefined) line.textContent = line.dataset.hint;
    else if (typeof what === "number") line.textContent = this.told(what);
    else line.textContent = filled(line.dataset.class, { ...what, from: this.error(what.from), to: this.error(what.to) });
    this.charts.over.mark(this.picked, this.hovered);
    this.charts.map.mark(this.picked, this.hovered);
    for (const row of this.part("table").querySelectorAll("tr.hovered")) row.classList.remove("hovered");
    if (this.hovered !== null) this.part("table").querySelector(`tr[data-index="${this.hovered}"]`)?.classList.add("hovered");
  }

  error(value) {
    return `${numbers.number(value, ERROR_DIGITS)} ${units.symbol("mm")}`;
  }

  told(i) {
    const { config, nest, expected_mm } = this.found;
    const index = Number(this.part("variable").value);
    const value = this.columns[index][i];
    return filled(this.part("line").dataset.reading, {
      config: config[i], nest: nest[i], after: this.error(this.after[i]), before: this.error(this.before[i]),
      expected: this.error(units.shown(expected_mm[i], "mm", 0).value),
      variable: this.labelled(index), value: Number.isNaN(value) ? "–" : numbers.number(value, 2),
    });
  }

  // One more time: no longer. `adding`: several are added to those that are picked.
  pick(which, adding = true) {
    if (!adding) this.picked.clear();
    if (which.length === 1 && this.picked.has(which[0])) this.picked.delete(which[0]);
    else which.forEach((i) => this.picked.add(i));
    this.mark();
  }

  mark() {
    for (const chart of Object.values(this.charts)) chart.mark(this.picked, this.hovered);
    this.rows();
  }

  // The arm where the last picked reading was taken, else where the worst was; the link leads there.
  inSpace() {
    const one = [...this.picked].at(-1) ?? this.worst()[0];
    const query = new URLSearchParams(this.dataset.query);
    query.set("config", this.found.config[one]);
    document.querySelector("robot-view").show(`/api/v1${this.dataset.result}/space?${query}`);
  }

  // Each reading once, as requests name it: a sensor has one for each of its axes.
  readings(which) {
    const { config, nest, base_point, target } = this.found;
    const named = which.map((i) => ({ config: config[i], nest: nest[i], base_point: base_point?.[i] ?? null, target: target?.[i] ?? null }));
    return [...new Map(named.map((one) => [JSON.stringify(one), one])).values()];
  }

  list(part, readings) {
    const names = JSON.parse(this.dataset.names);
    const told = (one) => filled(names[one.base_point !== null ? "leg" : one.target !== null ? "contact" : "point"], one);
    this.part(part).replaceChildren(...readings.map((one) => Object.assign(document.createElement("li"), { textContent: told(one) })));
  }

  // Whoever sets further readings aside takes over those before: a result has one reason and one person.
  askAside() {
    const dialogue = this.part("aside-dialogue");
    const readings = [...JSON.parse(dialogue.dataset.earlier), ...this.readings([...this.picked])];
    const ask = JSON.parse(dialogue.dataset.ask);
    dialogue.querySelector("form").dataset.asks = JSON.stringify([{ ...ask, body: { ...ask.body, set_aside: { readings } } }]);
    this.list("aside-list", readings);
    dialogue.showModal();
  }

  // In a session that takes configurations still, else in one that is planned as it was.
  askAgain() {
    const { session } = this.part("again").dataset;
    const dialogue = this.part("again-dialogue");
    const configs = [...new Set([...this.picked].map((i) => this.found.config[i]))];
    if (!dialogue) return location.assign(`/sessions/${session}/again?${new URLSearchParams(configs.map((config) => ["configurations", config]))}`);
    this.list("again-list", this.readings([...this.picked]));
    return dialogue.showModal();
  }

  async measureAgain(form, say) {
    const { session } = this.part("again").dataset;
    const { leftOut, unreachable } = form.closest("dialog").dataset;
    const joints = this.found.variables.filter(({ name }) => name === "joint");
    const configurations = [...this.picked].map((i) => ({ joints_deg: joints.map(({ values }) => values[i]), nest: this.found.nest[i] }));
    const person = form.elements.person?.value.trim();
    const added = await post(`/api/v1/sessions/${session}/configurations`, { ...(person && { person }), configurations, leave_out_unfit: true }, unreachable);
    if (!added.left_out.length) return location.assign(`/sessions/${session}`);
    return say([added.sentence, ...added.left_out.map((entry) => filled(leftOut, entry))].join(" "));
  }

  worst() {
    return [...this.after.keys()].sort((a, b) => Math.abs(this.after[b]) - Math.abs(this.after[a]));
  }

  rows() {
    const which = this.picked.size ? this.worst().filter((i) => this.picked.has(i)) : this.worst().slice(0, WORST);
    const caption = this.part("caption");
    caption.textContent = filled(this.picked.size ? caption.dataset.picked : caption.dataset.worst, { n: which.length, total: this.after.length });
    for (const button of this.querySelectorAll("button[data-picked]")) button.disabled = this.picked.size === 0;
    this.part("table").tBodies[0].replaceChildren(...which.slice(0, MOST_ROWS).map((i) => this.row(i)));
  }

  row(i) {
    const row = document.createElement("tr");
    row.dataset.index = i;
    row.classList.toggle("picked", this.picked.has(i));
    const { config, nest, expected_mm } = this.found;
    const expected = units.shown(expected_mm[i], "mm", 0).value;
    const cells = [config[i], nest[i], ...[this.before[i], this.after[i], expected].map((value) => numbers.number(value, ERROR_DIGITS))];
    const heads = this.part("table").tHead.rows[0].cells;
    cells.forEach((text, k) => (Object.assign(row.insertCell(), { textContent: text }).dataset.label = heads[k].textContent));
    return row;
  }

  // What is picked, else everything, as columns that other programs read: kept units, decimal points.
  csv() {
    const { config, nest, before_mm, after_mm, expected_mm, variables } = this.found;
    const axes = before_mm[0].length === 3 ? ["x_", "y_", "z_"] : [""];
    const named = variables.map(({ name, joint, unit }) => [name + (joint ?? ""), unit.replace(/[^A-Za-z]/g, "")].filter(Boolean).join("_"));
    const head = ["config", "nest", ...axes.map((axis) => `before_${axis}mm`), ...axes.map((axis) => `after_${axis}mm`), "expected_mm", ...named];
    const which = this.picked.size ? [...this.picked].sort((a, b) => a - b) : [...config.keys()];
    const lines = which.map((i) => [config[i], nest[i], ...before_mm[i], ...after_mm[i], expected_mm[i], ...variables.map(({ values }) => values[i] ?? "")]);
    return [head, ...lines].map((cells) => cells.join(",")).join("\n") + "\n";
  }

  async picture({ picture, form }) {
    const chart = this.charts[picture];
    const kept = form === "png" ? await chart.png() : new Blob([chart.svg()], { type: "image/svg+xml" });
    keep(kept, `${picture}.${form}`);
  }
}

// Kept values as they are shown; NaN where one is not known. Conversions of units are straight lines.
function inUnits(values, unit) {
  const [offset, one] = [0, 1].map((value) => units.shown(value, unit, 0).value);
  return Float64Array.from(values, (value) => (value === null ? NaN : offset + (one - offset) * value));
}

// Larger where the error is larger; nineteen of twenty are told apart.
function sizes(errors) {
  const all = Float64Array.from(errors, Math.abs).sort();
  const most = all[Math.floor(0.95 * (all.length - 1))] || 1;
  return Float64Array.from(errors, (error) => MARK_PX.least + (MARK_PX.most - MARK_PX.least) * Math.min(1, Math.abs(error) / most));
}

function keep(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

customElements.define("reading-charts", ReadingCharts);
