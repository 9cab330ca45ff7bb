// The picture of a step, drawn from the session's own geometry.

import { camera } from "../common/camera.js";
import { drawn } from "../common/elements.js";
import { placed } from "../common/labels.js";

const BALL_MM = 6.35; // radius of a half-inch ball
const SMALLEST_BALL_PX = { asked: 15, other: 8 };
const CAPTION_PX = 28; // the lower edge of the picture says whose view it is
const RING_PX = 9; // around the balls that are asked for
const LETTERS_PX = { asked: 34, other: 20 };
const ARM_MM = [46, 24]; // half thickness at the base and at the wrist
const GRID_MM = 100;
const GRID_LINES = 5; // either way of the middle
const FRAMED_JOINTS = 1; // last points of the arm that must be in the picture; the rest may be cut off

const path = (points) => points.map((point, i) => `${i ? "L" : "M"}${point.x.toFixed(1)} ${point.y.toFixed(1)}`).join("");

function lowest(points) {
  return Math.min(...points.map(([, , z]) => z));
}

// Lines on the plane of the cups, so that the eye has a ground to stand on.
function ground(scene, see) {
  const cups = scene.points.filter((point) => point.kind === "cup").map((point) => point.position_mm);
  const plane = cups.length ? lowest(cups) : 0;
  const [x, y] = scene.look_at_mm.map((value) => Math.round(value / GRID_MM) * GRID_MM);
  const reach = GRID_LINES * GRID_MM;
  const lines = [];
  for (let at = -reach; at <= reach; at += GRID_MM) {
    lines.push([[x + at, y - reach, plane], [x + at, y + reach, plane]]);
    lines.push([[x - reach, y + at, plane], [x + reach, y + at, plane]]);
  }
  return drawn("path", { class: "ground", d: lines.map((line) => path(line.map(see))).join("") });
}

function plate(scene, kind, see) {
  const corners = scene.points.filter((point) => point.kind === kind).map((point) => see(point.position_mm));
  if (corners.length < 3) return null;
  return drawn("path", { class: `plate ${kind}`, d: `${path(hull(corners))}Z` });
}

// Corners in the order in which they are walked around; four cups need not come in it.
function hull(corners) {
  const middle = { x: 0, y: 0 };
  for (const corner of corners) {
    middle.x += corner.x / corners.length;
    middle.y += corner.y / corners.length;
  }
  const angle = (corner) => Math.atan2(corner.y - middle.y, corner.x - middle.x);
  return [...corners].sort((a, b) => angle(a) - angle(b));
}

function arm(points_mm, see, style) {
  const seen = points_mm.map(see);
  const group = drawn("g", { class: `arm ${style}` });
  const thickness = (i) => {
    const share = i / Math.max(seen.length - 1, 1);
    return Math.max(9, 2 * seen[i].scale * (ARM_MM[0] + share * (ARM_MM[1] - ARM_MM[0])));
  };
  for (const layer of ["edge", "body"]) {
    seen.slice(1).forEach((point, i) => {
      const width = thickness(i + 1) - (layer === "body" ? 5 : 0);
      group.append(drawn("path", { class: layer, d: path([seen[i], point]), "stroke-width": width }));
    });
  }
  for (const [i, point] of seen.entries())
    group.append(drawn("circle", { class: "joint", cx: point.x, cy: point.y, r: thickness(i) * 0.24 }));
  return group;
}

// From the flange to the nests: the fixture that the arm carries.
function holder(scene, see) {
  const nests = scene.points.filter((point) => point.kind === "nest");
  const flange = see(scene.arm_mm.at(-1));
  return drawn("path", {
    class: "holder",
    d: nests.map((nest) => path([flange, see(nest.position_mm)])).join(""),
  });
}

function ballbar(ends, style) {
  const [a, b] = ends;
  const at = (share) => ({ x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y) });
  const group = drawn("g", { class: `ballbar ${style}` });
  group.append(drawn("path", { class: "rod-edge", d: path(ends) }), drawn("path", { class: "rod", d: path(ends) }));
  group.append(drawn("path", { class: "tube-edge", d: path([at(0.2), at(0.62)]) }));
  group.append(drawn("path", { class: "tube", d: path([at(0.2), at(0.62)]) }));
  return group;
}

function ball(point) {
  const group = drawn("g", { class: `point ${point.kind} ${point.asked ? "asked" : "other"}` });
  if (point.asked) group.append(drawn("circle", { class: "ring", cx: point.x, cy: point.y, r: point.ball_px + RING_PX }));
  group.append(drawn("circle", { class: "ball", cx: point.x, cy: point.y, r: point.ball_px }));
  return group;
}

function rim(point, where) {
  const away = point.radius / (Math.hypot(where.x - point.x, where.y - point.y) || 1);
  return { x: point.x + away * (where.x - point.x), y: point.y + away * (where.y - point.y) };
}

function nameTag(point, where) {
  const group = drawn("g", { class: `tag ${point.kind} ${point.asked ? "asked" : "other"}`, "data-name": point.name });
  const [left, top] = [where.x - point.width / 2, where.y - point.height / 2];
  const chip = { x: left, y: top, width: point.width, height: point.height, rx: 7 };
  const text = { x: where.x, y: where.y, "font-size": LETTERS_PX[point.asked ? "asked" : "other"] };
  if (where.far > 1.4) group.append(drawn("path", { class: "leader", d: path([rim(point, where), where]) }));
  group.append(drawn("rect", chip), drawn("text", text, point.name));
  return group;
}

function seenPoint(point, asked, see) {
  const manner = asked.includes(point.name) ? "asked" : "other";
  const seen = see(point.position_mm);
  const ball_px = Math.max(SMALLEST_BALL_PX[manner], BALL_MM * seen.scale);
  const radius = ball_px + (manner === "asked" ? RING_PX + 3 : 0);
  return { ...seen, ...point, asked: manner === "asked", ball_px, radius, ...chipSize(point.name, LETTERS_PX[manner]) };
}

function chipSize(name, letters_px) {
  return { width: letters_px * (0.66 * name.length + 0.6), height: letters_px * 1.3 };
}

// Which of two arms is the one of now; where it is not known how the arm stands, its base.
function moments(scene, see, words) {
  const tag = (at, name) => ({ ...at, name, kind: "moment", asked: false, radius: 24, ...chipSize(name, LETTERS_PX.other) });
  if (!stands(scene)) return seenBase(scene).map((base) => tag(see(base), words.robot));
  if (!scene.before_move_arm_mm) return [];
  const said = [[scene.before_move_arm_mm, words.now], [scene.arm_mm, words.then]];
  return said.map(([joints, name]) => {
    // At the elbow: the flange has the names of the nests around it.
    return tag(see(joints[Math.ceil(joints.length / 2)]), name);
  });
}

// Of an arm whose angles nobody has read, only the base is known.
function stands(scene) {
  return scene.arm_mm.length > 1;
}

// A triangle of the tool stands nowhere then: it is seen from near.
function seenBase(scene) {
  const alone = scene.points.length > 0 && scene.points.every((point) => point.kind === "nest");
  return alone ? [] : scene.arm_mm;
}

function framed(scene) {
  const arms = [stands(scene) ? scene.arm_mm : seenBase(scene), scene.before_move_arm_mm ?? []];
  const points = scene.points.map((point) => point.position_mm);
  const moving = scene.before_move_arm_mm !== null;
  return [...points, ...arms.flatMap((joints) => (moving ? joints : joints.slice(-FRAMED_JOINTS)))];
}

function arrow(scene, see) {
  const [from, to] = [see(scene.before_move_arm_mm.at(-1)), see(scene.arm_mm.at(-1))];
  if (Math.hypot(to.x - from.x, to.y - from.y) < 30) return null;
  const stop = { x: to.x - (to.x - from.x) * 0.08, y: to.y - (to.y - from.y) * 0.08 };
  return drawn("path", { class: "way", d: path([from, stop]), "marker-end": "url(#arrow)" });
}

function arrowHead() {
  const shape = drawn("path", { d: "M0 0L10 5L0 10Z" });
  const marker = { id: "arrow", viewBox: "0 0 10 10", refX: 8, refY: 5, markerWidth: 5, markerHeight: 5, orient: "auto" };
  return drawn("defs", {}, drawn("marker", marker, shape));
}

function arms(scene, see) {
  if (!stands(scene)) return [arm(seenBase(scene), see, "here")];
  if (!scene.before_move_arm_mm) return [arm(scene.arm_mm, see, "here"), holder(scene, see)];
  return [
    arrowHead(), arm(scene.before_move_arm_mm, see, "here"), arm(scene.arm_mm, see, "target"),
    holder(scene, see), arrow(scene, see),
  ];
}

// Draws `scene` into `svg` of that size [px]. `asked`: names of the points the step is about;
// `suspected`: the pair that a doubtful reading goes with; `words`: what `now`, `then` and `robot` are called.
export function drawPicture(svg, scene, { asked, suspected, words }, whole) {
  svg.setAttribute("viewBox", `0 0 ${whole.width} ${whole.height}`);
  const size = { ...whole, height: whole.height - CAPTION_PX };
  const see = camera(scene, framed(scene), size.width, size.height);
  const points = scene.points.map((point) => seenPoint(point, [...asked, ...suspected], see));
  points.sort((a, b) => b.asked - a.asked);
  const ends = (names) => names.map((name) => points.find((point) => point.name === name)).filter(Boolean);
  const pairs = [[asked, "asked"], [suspected, "suspected"]]
    .map(([names, style]) => ({ line: ends(names), style }))
    .filter(({ line }) => line.length === 2);
  const named = [...points, ...moments(scene, see, words)];
  const tags = placed(named, pairs.map(({ line }) => ({ line, thickness: 26 })), size);
  const balls = [...points].reverse().map(ball);
  const layers = [
    ground(scene, see), plate(scene, "cup", see), ...arms(scene, see), plate(scene, "nest", see),
    ...pairs.map(({ line, style }) => ballbar(line, style)), ...balls,
    ...named.map((point, i) => nameTag(point, tags[i])).reverse(),
  ];
  svg.replaceChildren(...layers.filter(Boolean));
}
