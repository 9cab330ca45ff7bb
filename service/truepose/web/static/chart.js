// Charts of readings on uPlot, which draws axes and scales: points and classes are drawn here, by the thousand.
// Whoever hovers, picks, drags or uses the keys is answered by the page that owns the chart.

import { Chart as Plot } from "/static/packages/charts.js";

const NEAR_PX = 24; // of a pointer to a point
const DRAGGED_PX = 6; // less is a tap
const MARGIN = 0.04; // of an axis, around what is shown
const STEP = 0.6; // of what is seen, at each step of zoom
const POINT_PX = 2.5;
const HEIGHT_PX = 210;
const [FAINT, TOP] = [0.5, 12]; // how much of what stands back is seen; pixels above a chart
const COLOURS = ["ink", "line", "paper", "before", "after"];

const range = ([low, high]) => {
  const around = (high - low || Math.abs(high) || 1) * MARGIN;
  return { min: low - around, max: high + around };
};

export function extent(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low > high ? [0, 1] : [low, high];
}

class Chart {
  // `told`: hovered(index), picked(indices), and numbers as the page writes them: number(value).
  constructor(host, told) {
    Object.assign(this, { host, told, ticks: [], zoomed: null, drags: "zoom", picked: new Set(), hovered: null });
    host.tabIndex = 0;
    host.addEventListener("keydown", (event) => this.key(event));
    this.size = new ResizeObserver(() => this.plot?.setSize(this.room()));
    this.size.observe(host);
  }

  close() {
    this.size.disconnect();
    this.plot?.destroy();
  }

  room() {
    return { width: this.host.clientWidth, height: HEIGHT_PX };
  }

  // A token as this look resolves it, as drawings need it.
  resolved(name) {
    this.host.style.color = `var(--${name})`;
    const colour = getComputedStyle(this.host).color;
    this.host.style.color = "";
    return colour;
  }

  colour(name) {
    return this.colours[name];
  }

  // Anew: other axes, another look.
  open(labels) {
    this.plot?.destroy();
    this.labels = labels;
    this.colours = Object.fromEntries(COLOURS.map((name) => [name, this.resolved(name)]));
    const axis = (label, index) => ({
      label, stroke: this.colour("ink"), font: "12px system-ui", labelFont: "600 12px system-ui",
      grid: { stroke: this.colour("line"), width: 1 }, ticks: { show: false },
      size: index ? 62 : 38, labelSize: 22,
      values: (_, at) => this.marked(index, at),
    });
    this.plot = new Plot({
      ...this.room(), legend: { show: false }, cursor: { show: false }, padding: [TOP, TOP, 0, 0],
      scales: { x: { time: false, range: () => this.bounds("x") }, y: { range: () => this.bounds("y") } },
      axes: labels.map(axis), series: [{}, { show: false }],
      hooks: { drawClear: [() => this.ground()], draw: [() => this.drawClipped()] },
    }, [[0, 1], [0, 1]], this.host);
    this.listen(this.plot.over);
  }

  marked(index, at) {
    const step = at.length > 1 ? Math.abs(at[1] - at[0]) : 1;
    const digits = [0, 1, 2, 3, 4, 5, 6].find((n) => isWhole(step * 10 ** n)) ?? 6;
    const texts = at.map((value) => this.told.number(value, digits));
    this.ticks[index] = at.map((value, i) => [value, texts[i]]);
    return texts;
  }

  bounds(scale) {
    const { min, max } = this.zoomed?.[scale] ?? range(this.whole()[scale]);
    return [min, max];
  }

  ground() {
    const { ctx } = this.plot;
    ctx.fillStyle = this.colour("paper");
    ctx.fillRect(0, 0, ctx.canvas.width, ctx.canvas.height);
  }

  drawClipped() {
    const { ctx, bbox } = this.plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    this.draw(ctx, devicePixelRatio);
    ctx.restore();
  }

  // From values to pixels of the canvas, or of the page.
  placing(ofCanvas = true) {
    const { bbox, scales } = this.plot;
    const ratio = ofCanvas ? 1 : devicePixelRatio;
    const [left, top] = ofCanvas ? [bbox.left, bbox.top] : [0, 0];
    const { x, y } = scales;
    const [width, height] = [bbox.width / ratio, bbox.height / ratio];
    return {
      x: (value) => left + ((value - x.min) / (x.max - x.min)) * width,
      y: (value) => top + ((y.max - value) / (y.max - y.min)) * height,
    };
  }

  redraw() {
    this.plot?.redraw(false);
  }

  zoom(zoomed) {
    this.zoomed = zoomed;
    const bounds = Object.fromEntries(["x", "y"].map((scale) => [scale, this.bounds(scale)]));
    this.plot.batch(() => {
      for (const [scale, [min, max]] of Object.entries(bounds)) this.plot.setScale(scale, { min, max });
    });
  }

  reset() {
    this.zoom(null);
  }

  // Closer to, or farther from, the middle or the point that is hovered.
  closer(times, at) {
    const zoomed = {};
    for (const scale of ["x", "y"]) {
      const [min, max] = this.bounds(scale);
      const middle = at?.[scale] ?? (min + max) / 2;
      zoomed[scale] = { min: middle + (min - middle) * times, max: middle + (max - middle) * times };
    }
    this.zoom(zoomed);
  }

  listen(over) {
    let start = null;
    const at = (event) => ({ x: event.offsetX, y: event.offsetY });
    over.addEventListener("pointerdown", (event) => (start = { ...at(event), finger: event.pointerType === "touch" }));
    over.addEventListener("pointermove", (event) => {
      const now = at(event);
      if (start && !start.finger && far(start, now)) this.plot.setSelect(box(start, now), false);
      this.told.hovered(this.near(now));
    });
    over.addEventListener("pointerup", (event) => {
      const now = at(event);
      if (start && !start.finger && far(start, now)) this.dragged(box(start, now));
      else if (start) this.told.picked(this.at(now));
      start = null;
      this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    });
    over.addEventListener("pointerleave", () => ((start = null), this.told.hovered(null)));
    over.addEventListener("dblclick", () => this.reset());
  }

  dragged({ left, top, width, height }) {
    const value = (px, scale) => this.plot.posToVal(px, scale);
    const area = {
      x: { min: value(left, "x"), max: value(left + width, "x") },
      y: { min: value(top + height, "y"), max: value(top, "y") },
    };
    if (this.drags === "zoom") this.zoom(area);
    else this.told.picked(this.within(area));
  }

  key(event) {
    const acts = {
      ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1), Enter: () => this.pickHovered(),
      "+": () => this.closer(STEP, this.hoveredAt()), "-": () => this.closer(1 / STEP), Escape: () => this.reset(),
    };
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  }

  // As a picture to keep.
  async png() {
    return new Promise((resolve) => this.plot.ctx.canvas.toBlob(resolve));
  }

  svg() {
    const { width, height } = this.room();
    const { bbox } = this.plot;
    const [left, top, wide, high] = [bbox.left, bbox.top, bbox.width, bbox.height].map((px) => px / devicePixelRatio);
    const to = this.placing(false);
    const text = (x, y, said, more = "") => `<text x="${x}" y="${y}" ${more}>${escaped(said)}</text>`;
    const [across, up] = this.ticks;
    const marks = [
      ...across.map(([value, said]) => text(left + to.x(value), top + high + 16, said, 'text-anchor="middle"')),
      ...up.map(([value, said]) => text(left - 6, top + to.y(value) + 4, said, 'text-anchor="end"')),
    ];
    const [xLabel, yLabel] = this.labels;
    const labels = text(left + wide / 2, height - 4, xLabel, 'text-anchor="middle"')
      + text(0, 0, yLabel, `text-anchor="middle" transform="translate(14 ${top + high / 2}) rotate(-90)"`);
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" font-family="system-ui" font-size="12">`
      + `<rect width="100%" height="100%" fill="#fff"/>`
      + `<svg x="${left}" y="${top}" width="${wide}" height="${high}">${this.shapes(to).join("")}</svg>`
      + `<rect x="${left}" y="${top}" width="${wide}" height="${high}" fill="none" stroke="#888"/>${marks.join("")}${labels}</svg>`;
  }
}

// Points, of which some are picked; `before` faintly behind them.
export class ScatterChart extends Chart {
  show({ x, y, before = [], radius = null, labels }) {
    Object.assign(this, { x, y, before, radius });
    this.zoomed = null;
    this.open(labels);
  }

  mark(picked, hovered) {
    Object.assign(this, { picked, hovered });
    this.redraw();
  }

  whole() {
    const [low, high] = extent(this.y);
    const [lowest, highest] = this.before.length ? extent(this.before) : [low, high];
    return { x: extent(this.x), y: [Math.min(low, lowest), Math.max(high, highest)] };
  }

  draw(ctx, ratio) {
    const to = this.placing();
    this.dots(ctx, to, this.x.keys(), this.before, this.colour("before"), FAINT, ratio);
    this.dots(ctx, to, this.x.keys(), this.y, this.colour("after"), this.picked.size ? FAINT * FAINT : 1, ratio);
    this.dots(ctx, to, this.picked, this.y, this.colour("ink"), 1, 1.4 * ratio);
    if (this.hovered === null) return;
    ctx.strokeStyle = this.colour("ink");
    ctx.lineWidth = 2 * ratio;
    ctx.beginPath();
    ctx.arc(to.x(this.x[this.hovered]), to.y(this.y[this.hovered]), 8 * ratio, 0, 2 * Math.PI);
    ctx.stroke();
  }

  dots(ctx, to, which, values, colour, alpha, ratio) {
    if (!values.length) return;
    ctx.fillStyle = colour;
    ctx.globalAlpha = alpha;
    ctx.beginPath();
    for (const i of which) {
      if (Number.isNaN(this.x[i]) || Number.isNaN(values[i])) continue;
      const [px, py, size] = [to.x(this.x[i]), to.y(values[i]), (this.radius?.[i] ?? POINT_PX) * ratio];
      ctx.moveTo(px + size, py);
      ctx.arc(px, py, size, 0, 2 * Math.PI);
    }
    ctx.fill();
    ctx.globalAlpha = 1;
  }

  near(at, within = NEAR_PX) {
    const to = this.placing(false);
    let [nearest, least] = [null, within];
    for (const i of this.x.keys()) {
      const away = Math.hypot(to.x(this.x[i]) - at.x, to.y(this.y[i]) - at.y);
      if (away < least) [nearest, least] = [i, away];
    }
    return nearest;
  }

  at(place) {
    const nearest = this.near(place);
    return nearest === null ? [] : [nearest];
  }

  within({ x, y }) {
    return [...this.x.keys()].filter((i) => inside(this.x[i], x) && inside(this.y[i], y));
  }

  hoveredAt() {
    const i = this.hovered;
    return i === null ? null : { x: this.x[i], y: this.y[i] };
  }

  // The next point to the right or left of the one that is hovered.
  step(by) {
    const order = [...this.x.keys()].filter((i) => !Number.isNaN(this.x[i])).sort((a, b) => this.x[a] - this.x[b]);
    const now = order.indexOf(this.hovered);
    this.told.hovered(order[(now + by + order.length) % order.length]);
  }

  pickHovered() {
    if (this.hovered !== null) this.told.picked([this.hovered]);
  }

  shapes(to) {
    const dots = (values, colour, alpha) => Array.from(values, (value, i) => Number.isNaN(value) || Number.isNaN(this.x[i]) ? ""
      : `<circle cx="${to.x(this.x[i]).toFixed(1)}" cy="${to.y(value).toFixed(1)}" r="${this.radius?.[i] ?? POINT_PX}" fill="${colour}" opacity="${alpha}"/>`);
    return [...dots(this.before, this.colour("before"), FAINT), ...dots(this.y, this.colour("after"), 1)];
  }
}

// How many readings are how far off, before and after, in the same classes.
export class Histogram extends Chart {
  show({ before, after, classes, labels }) {
    const [low, high] = extent([...before, ...after]);
    const width = (high - low || 1) / classes;
    const of = (value) => Math.min(classes - 1, Math.floor((value - low) / width));
    const counted = (values) => {
      const counts = new Array(classes).fill(0);
      for (const value of values) counts[of(value)] += 1;
      return counts;
    };
    Object.assign(this, { low, width, of, values: after, counts: { before: counted(before), after: counted(after) }, hovered: null });
    this.zoomed = null;
    this.open(labels);
  }

  mark(picked) {
    this.picked = picked;
    this.redraw();
  }

  whole() {
    const most = Math.max(...this.counts.before, ...this.counts.after);
    return { x: [this.low, this.low + this.width * this.counts.after.length], y: [0, most] };
  }

  bars(counts, to) {
    return counts.map((count, k) => {
      const [left, right] = [to.x(this.low + k * this.width), to.x(this.low + (k + 1) * this.width)];
      return [left, to.y(count), right - left - 1, to.y(0) - to.y(count)];
    });
  }

  draw(ctx) {
    const to = this.placing();
    const of = new Array(this.counts.after.length).fill(0);
    for (const i of this.picked) of[this.of(this.values[i])] += 1;
    for (const [counts, name, alpha] of [[this.counts.before, "before", FAINT], [this.counts.after, "after", 0.8], [of, "ink", 1]]) {
      ctx.fillStyle = this.colour(name);
      ctx.globalAlpha = alpha;
      for (const bar of this.bars(counts, to)) ctx.fillRect(...bar);
    }
    ctx.globalAlpha = 1;
  }

  // A class, not a reading: what is told is its bounds and counts.
  near({ x }) {
    const k = this.of(this.plot.posToVal(x, "x"));
    return k in this.counts.after ? this.classAt(k) : null;
  }

  classAt(k) {
    const [from, to] = [this.low + k * this.width, this.low + (k + 1) * this.width];
    return { from, to, before: this.counts.before[k], after: this.counts.after[k] };
  }

  at({ x }) {
    return this.ofClass(this.of(this.plot.posToVal(x, "x")));
  }

  ofClass(k) {
    return [...this.values.keys()].filter((i) => this.of(this.values[i]) === k);
  }

  within({ x }) {
    return [...this.values.keys()].filter((i) => inside(this.values[i], x));
  }

  hoveredAt() {
    return null;
  }

  step(by) {
    const last = this.counts.after.length - 1;
    this.stepped = Math.max(0, Math.min(last, (this.stepped ?? -1) + by));
    this.told.hovered(this.classAt(this.stepped));
  }

  pickHovered() {
    if (this.stepped !== undefined) this.told.picked(this.ofClass(this.stepped));
  }

  shapes(to) {
    return [["before", FAINT], ["after", 0.8]].flatMap(([name, alpha]) => this.bars(this.counts[name], to).map(([x, y, width, height]) =>
      `<rect x="${x.toFixed(1)}" y="${y.toFixed(1)}" width="${Math.max(0, width).toFixed(1)}" height="${height.toFixed(1)}" fill="${this.colour(name)}" opacity="${alpha}"/>`));
  }
}

const inside = (value, { min, max }) => value >= min && value <= max;
const isWhole = (number) => Math.abs(number - Math.round(number)) < 1e-6 && number > 0.5;
const far = (from, to) => Math.hypot(to.x - from.x, to.y - from.y) > DRAGGED_PX;
const escaped = (text) => text.replace(/[&<>]/g, (sign) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[sign]);

function box(from, to) {
  const [left, top] = [Math.min(from.x, to.x), Math.min(from.y, to.y)];
  return { left, top, width: Math.abs(to.x - from.x), height: Math.abs(to.y - from.y) };
}
