// <plan-view src="...space">: a session in space: where the arm goes, what was measured, what comes next.

import { filled, SpaceView } from "./space-view.js";

const COLOURS = { measured: "good", skipped: "bad", to_come: "accent" };

class PlanView extends SpaceView {
  poses() {
    return this.space.stops;
  }

  arrange() {
    const next = this.space.stops.findIndex((stop) => stop.config === this.space.next_config);
    this.shown = Math.max(0, next);
  }

  corners() {
    return [...this.space.fixed_mm, ...super.corners()];
  }

  drawing() {
    const { stops, fixed_mm } = this.space;
    const places = Object.entries(COLOURS).map(([state, colour]) => {
      const those = stops.filter((stop) => stop.state === state).map((stop) => stop.place_mm);
      return this.bodies.places(those, this.colour(colour), 7);
    });
    const fixed = fixed_mm.map((place) => this.bodies.ball(place, 14, this.colour("ink")));
    return [...places, ...fixed, ...this.armNow(), ...this.instrument()];
  }

  caption() {
    const stop = this.space.stops[this.shown];
    const line = this.part("pose");
    const state = stop.config === this.space.next_config ? "next" : stop.state;
    line.textContent = filled(line.dataset[state.replace("to_come", "coming")], stop);
  }
}

customElements.define("plan-view", PlanView);
