// <robot-view src="...space">: a result in space, to be turned. The page brings its controls and their words;
// without WebGL, or without the packages of the pages, it says so and leaves the still picture its place.

const number = (value) => new Intl.NumberFormat(document.documentElement.lang, { maximumSignificantDigits: 3 }).format(value);

class RobotView extends HTMLElement {
  connectedCallback() {
    this.pose = 0;
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

  async open() {
    this.seen.disconnect();
    try {
      const [space, stages, bodies] = await Promise.all([
        fetch(this.getAttribute("src")).then((answer) => (answer.ok ? answer.json() : Promise.reject(new Error(answer.status)))),
        import("/static/space-stage.js"),
        import("/static/space-bodies.js"),
      ]);
      this.show(space, new stages.Stage(this.part("stage")), bodies);
    } catch {
      this.part("missing").hidden = false;
      this.part("live").hidden = true;
    }
  }

  show(space, stage, bodies) {
    Object.assign(this, { space, stage, bodies });
    for (const name of ["before", "after"])
      this.part(name).addEventListener("click", () => this.choose(name));
    this.part("previous").addEventListener("click", () => this.step(-1));
    this.part("next").addEventListener("click", () => this.step(1));
    this.looks = new MutationObserver(() => this.paint());
    this.looks.observe(document.documentElement, { attributes: true, attributeFilter: ["data-look"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
    this.paint();
    stage.look(...this.extent());
    this.dataset.ready = "";
  }

  extent() {
    const { points_mm, poses } = this.space;
    const all = [...points_mm, ...poses.flatMap((pose) => pose.pieces_mm.map((piece) => piece.slice(0, 3)))];
    const ends = [0, 1, 2].map((axis) => [Math.min(...all.map((p) => p[axis])), Math.max(...all.map((p) => p[axis]))]);
    return [ends.map(([low, high]) => (low + high) / 2), Math.hypot(...ends.map(([low, high]) => high - low)) / 2];
  }

  colour(name) {
    return getComputedStyle(this).getPropertyValue(`--${name}`).trim();
  }

  // One of the two: drawn together, errors of another scale would look as long as the others.
  choose(chosen) {
    for (const name of ["before", "after"]) this.part(name).setAttribute("aria-pressed", String(name === chosen));
    this.paint();
  }

  step(by) {
    this.pose = (this.pose + by + this.space.poses.length) % this.space.poses.length;
    this.paint();
  }

  // Everything anew: a few hundred bodies are made in milliseconds, and no state can be stale.
  paint() {
    const { arm, arrows, ball, ground, places } = this.bodies;
    const { points_mm, poses, instrument_mm } = this.space;
    if (this.drawn) this.stage.scene.remove(...this.drawn);
    this.drawn = [ground(this.extent()[1], this.colour("line")), places(points_mm, this.colour("ink"))];
    if (poses.length) this.drawn.push(arm(poses[this.pose].pieces_mm, this.colour("muted")));
    if (instrument_mm) this.drawn.push(ball(instrument_mm, 40, this.colour("accent")));
    for (const name of ["before", "after"]) {
      if (this.part(name).getAttribute("aria-pressed") !== "true") continue;
      this.drawn.push(arrows(points_mm, this.space[`${name}_mm`], this.space[`times_${name}`], this.colour(name)));
    }
    this.stage.scene.add(...this.drawn);
    this.caption();
    this.stage.draw();
  }

  caption() {
    const pose = this.space.poses[this.pose];
    const line = this.part("pose");
    line.textContent = pose ? filled(line.dataset.words, pose) : "";
    for (const name of ["before", "after"]) {
      const key = this.part(`times-${name}`);
      key.textContent = filled(key.dataset.words, { times: this.space[`times_${name}`] });
    }
  }
}

function filled(words, values) {
  return words.replace(/\{(\w+)\}/g, (_, name) => number(values[name]));
}

customElements.define("robot-view", RobotView);
