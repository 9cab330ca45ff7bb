// <robot-view src="...space">: robot and errors of a result in space, to be turned.

import { filled, SpaceView } from "./space-view.js";
import { Units, numbers } from "./units.js";

const units = new Units();

class RobotView extends SpaceView {
  poses() {
    return this.space.poses;
  }

  corners() {
    return [...this.space.points_mm, ...super.corners()];
  }

  arrange() {
    for (const name of ["before", "after"]) this.part(name).addEventListener("click", () => this.choose(name));
  }

  // One of the two: drawn together, errors of another scale would look as long as the others.
  choose(chosen) {
    for (const name of ["before", "after"]) this.part(name).setAttribute("aria-pressed", String(name === chosen));
    this.paint();
  }

  drawing() {
    const { points_mm } = this.space;
    const name = this.part("before").getAttribute("aria-pressed") === "true" ? "before" : "after";
    const vectors = this.bodies.arrows(points_mm, this.space[`${name}_mm`], this.space[`times_${name}`], this.colour(name));
    return [this.bodies.places(points_mm, this.colour("ink")), ...this.armNow(), ...this.instrument(), vectors];
  }

  caption() {
    const pose = this.space.poses[this.shown];
    const line = this.part("pose");
    const off = (size_mm) => units.quantity(size_mm, "mm", 3, numbers);
    line.textContent = pose ? filled(line.dataset.words, { config: pose.config, before: off(pose.before_mm), after: off(pose.after_mm) }) : "";
    for (const name of ["before", "after"]) {
      const key = this.part(`times-${name}`);
      key.textContent = filled(key.dataset.words, { times: this.space[`times_${name}`] });
    }
  }
}

customElements.define("robot-view", RobotView);
