// Where the base fixture goes, in numbers that a tape measure finds.

import { element } from "../common/elements.js";

const HEADS = ["place.cup", "place.x", "place.y", "place.z", "place.distance"];
const FULL_DEG = 360;

function numbers({ name, position_mm }, base_mm) {
  const [x, y, z] = position_mm.map((value, i) => value - base_mm[i]);
  return { name, values: [x, y, z, Math.hypot(x, y)] };
}

// Of the line from the first cup to the second, seen from above.
function turn_deg([first, second]) {
  const [x, y] = [0, 1].map((i) => second.position_mm[i] - first.position_mm[i]);
  return (Math.round((Math.atan2(y, x) * FULL_DEG) / (2 * Math.PI)) + FULL_DEG) % FULL_DEG;
}

// As a tape measure shows it: millimetres, or hundredths of an inch.
function whole(value_mm, texts) {
  const { value, digits } = texts.units.shown(value_mm, "mm", 0);
  return digits === 0 ? texts.whole(value) : texts.number(value, digits);
}

// The arm begins at the robot's base, however it stands.
export function placeInNumbers(scene, texts) {
  const cups = scene.points.filter((point) => point.kind === "cup");
  if (cups.length < 2 || !scene.arm_mm.length) return [];
  const head = element("tr", {}, ...HEADS.map((key) => element("th", { scope: "col" }, texts.say(key))));
  const cell = (value) => element("td", {}, whole(value, texts));
  const row = ({ name, values }) => element("tr", {}, element("th", { scope: "row" }, name), ...values.map(cell));
  const rows = cups.map((cup) => row(numbers(cup, scene.arm_mm[0])));
  const table = element("table", { class: "place" }, element("thead", {}, head), element("tbody", {}, ...rows));
  const [first, second] = cups.map((cup) => cup.name);
  const said = texts.say("place.numbers", { first, second, unit: texts.units.symbol("mm"), turn: texts.units.quantity(turn_deg(cups), "°", 0, texts) });
  return [table, element("p", { class: "place-words" }, said)];
}
