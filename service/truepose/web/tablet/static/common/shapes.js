// Shapes that say the same as colour and word do, for whoever cannot tell the colours.

import { drawn } from "./elements.js";

const STATES = {
  in_range: "M4 20a16 16 0 1 0 32 0a16 16 0 1 0-32 0M11 20l7 7l12-14", // a tick in a circle
  out_low: "M20 36L3 8H37ZM20 13v9M20 26v1", // a triangle on its tip
  out_high: "M20 4L37 32H3ZM20 15v9M20 28v1", // a triangle on its base
  unstable: "M3 3H37V37H3ZM8 20q6-14 12 0t12 0", // a wave in a square
  no_signal: "M13 3H27L37 13V27L27 37H13L3 27V13ZM13 13L27 27M27 13L13 27", // a cross in an octagon
};

const BUTTONS = {
  back: "M16 5L7 12L16 19",
  retry: "M19 12a7 7 0 1 1-2-5M17 3v4h-4",
  skip: "M5 5L13 12L5 19M18 5V19",
  pause: "M8 5V19M16 5V19",
  resume: "M7 4L19 12L7 20Z",
  abort: "M6 6L18 18M18 6L6 18",
  sound: "M4 9H8L13 5V19L8 15H4ZM16 9q3 3 0 6M18.5 6.5q5 5.5 0 11",
  silent: "M4 9H8L13 5V19L8 15H4ZM16 9L21 15M21 9L16 15",
  stop: "M8 3H16L21 8V16L16 21H8L3 16V8Z",
};

export function stateShape(state) {
  return drawn("path", { d: STATES[state] });
}

export function buttonShape(act) {
  const icon = { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" };
  return drawn("svg", icon, drawn("path", { d: BUTTONS[act] }));
}

// An emergency stop: the red mushroom on its yellow plate.
export function cautionShape() {
  const shape = { class: "mushroom", viewBox: "0 0 40 40", "aria-hidden": "true" };
  const disc = (r, name) => drawn("circle", { cx: 20, cy: 20, r, class: name });
  return drawn("svg", shape, disc(19, "plate"), disc(12, "button"), drawn("path", { d: "M13.5 17a7 7 0 0 1 7-4", class: "gleam" }));
}
