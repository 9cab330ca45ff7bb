// What pictures in space share: they open when they are seen, draw anew when the look changes, and say so where
// this browser or this installation cannot show them. The page brings controls and words.

import { answerTo, answered } from "./api.js";

export const number = (value) =>
  new Intl.NumberFormat(document.documentElement.lang, { maximumSignificantDigits: 3 }).format(value);

// Text, such as a length with its unit, stays as it is.
const told = (value) => (typeof value === "number" ? number(value) : value);

export function filled(words, values) {
  return words.replace(/\{(\w+)\}/g, (_, name) => told(values[name]));
}

export class SpaceView extends HTMLElement {
  connectedCallback() {
    this.shown = 0; // which of the poses
    this.part("pose").textContent = this.part("pose").dataset.loading;
    this.seen = new IntersectionObserver(([entry]) => entry.isIntersecting && this.open());
    this.seen.observe(this);
  }

  disconnectedCallback() {
    this.seen.disconnect();
    this.looks?.disconnect();
    this.stage?.close();
  }

  part(name) {
    return this.querySelector(`[data-part="${name}"]`);
  }

  // A token as this look resolves it.
  colour(name) {
    const stage = this.part("stage");
    stage.style.color = `var(--${name})`;
    return getComputedStyle(stage).color;
  }

  async open() {
    this.seen.disconnect();
    try {
      if (!canDraw()) throw new Error("no WebGL");
      const [space, stages, bodies] = await Promise.all([
        answerTo(() => answered(this.getAttribute("src"), {}, "")),
        import("/static/space-stage.js"),
        import("/static/space-bodies.js"),
      ]);
      this.begin(space, new stages.Stage(this.part("stage")), bodies);
    } catch {
      this.part("missing").hidden = false;
      this.part("live").hidden = true;
    }
  }

  begin(space, stage, bodies) {
    Object.assign(this, { space, stage, bodies });
    this.part("previous").addEventListener("click", () => this.step(-1));
    this.part("next").addEventListener("click", () => this.step(1));
    this.looks = new MutationObserver(() => this.paint());
    this.looks.observe(document.documentElement, { attributes: true, attributeFilter: ["data-look"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
    this.arrange();
    this.paint();
    stage.look(...extent(this.corners()));
    this.dataset.ready = "";
  }

  // Another space in the same picture, once it has been opened.
  async show(src) {
    this.setAttribute("src", src);
    if (!this.stage) return;
    this.space = await answerTo(() => answered(src, {}, ""));
    this.shown = 0;
    this.paint();
  }

  arrange() {} // controls of its own

  step(by) {
    this.shown = (this.shown + by + this.poses().length) % this.poses().length;
    this.paint();
  }

  // Everything anew: a few hundred bodies are made in milliseconds, and no state can be stale.
  paint() {
    if (this.drawn) this.stage.scene.remove(...this.drawn);
    const grid = this.bodies.ground(extent(this.corners())[1], this.colour("line"));
    this.drawn = [grid, ...this.drawing()];
    this.stage.scene.add(...this.drawn);
    this.caption();
    this.stage.draw();
  }

  armNow() {
    const pose = this.poses()[this.shown];
    return pose ? [this.bodies.arm(pose.pieces_mm, this.colour("muted"))] : [];
  }

  instrument() {
    const place = this.space.instrument_mm;
    return place ? [this.bodies.ball(place, 40, this.colour("accent"))] : [];
  }

  corners() {
    return this.poses().flatMap((pose) => pose.pieces_mm.map((piece) => piece.slice(0, 3)));
  }
}

// Asked before the packages are fetched, which are large and would complain.
function canDraw() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

// Middle and half diagonal of points.
function extent(points) {
  const ends = [0, 1, 2].map((axis) => [Math.min(...points.map((p) => p[axis])), Math.max(...points.map((p) => p[axis]))]);
  return [ends.map(([low, high]) => (low + high) / 2), Math.hypot(...ends.map(([low, high]) => high - low)) / 2];
}
