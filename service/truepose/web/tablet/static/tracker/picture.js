// What the instrument sees: robot, fixed nests, configurations in sight and hidden ones, drawn from the session's own geometry.

import { camera } from "../common/camera.js";
import { drawn } from "../common/elements.js";
import { placed } from "../common/labels.js";

const CAPTION_PX = 30;
const LETTERS_PX = 20;
const ARM_PX = [16, 9];
const GRID_MM = 500;

const path = (points) => points.map((point, i) => `${i ? "L" : "M"}${point.x.toFixed(1)} ${point.y.toFixed(1)}`).join("");

function ground(scene, see) {
  const [x, y] = scene.look_at_mm.map((value) => Math.round(value / GRID_MM) * GRID_MM);
  const z = Math.min(0, ...scene.fixed_nests.map(({ position_mm }) => position_mm[2]));
  const lines = [];
  for (let at = -4; at <= 4; at += 1) {
    const off = at * GRID_MM, end = 4 * GRID_MM;
    lines.push([[x + off, y - end, z], [x + off, y + end, z]], [[x - end, y + off, z], [x + end, y + off, z]]);
  }
  return drawn("path", { class: "ground", d: lines.map((line) => path(line.map(see))).join("") });
}

function arm(points_mm, see) {
  const seen = points_mm.map(see);
  const group = drawn("g", { class: "arm here" });
  for (const layer of ["edge", "body"])
    seen.slice(1).forEach((point, i) => {
      const share = i / Math.max(seen.length - 2, 1);
      const width = ARM_PX[0] + share * (ARM_PX[1] - ARM_PX[0]) - (layer === "body" ? 4 : 0);
      group.append(drawn("path", { class: layer, d: path([seen[i], point]), "stroke-width": width }));
    });
  return group;
}

function head(at) {
  const { x, y } = at;
  const legs = drawn("path", { class: "legs", d: `M${x} ${y}L${x - 20} ${y + 44}M${x} ${y}L${x + 20} ${y + 44}M${x} ${y}V${y + 48}` });
  const body = drawn("rect", { class: "head", x: x - 13, y: y - 16, width: 26, height: 32, rx: 7 });
  return drawn("g", { class: "instrument" }, legs, body, drawn("circle", { class: "lens", cx: x, cy: y - 2, r: 6 }));
}

// A configuration in sight is a ring with a dot, a hidden one a cross: no colour alone.
function stop({ x, y }, { hidden, status, active }) {
  const name = `stop ${hidden ? "hidden" : "seen"} ${status ?? "open"}${active ? " active" : ""}`;
  const size = active ? 11 : 6;
  if (hidden) return drawn("path", { class: name, d: `M${x - size} ${y - size}L${x + size} ${y + size}M${x + size} ${y - size}L${x - size} ${y + size}` });
  return drawn("circle", { class: name, cx: x, cy: y, r: size });
}

function tag(point, where) {
  const group = drawn("g", { class: `tag ${point.kind} other`, "data-name": point.name });
  const chip = { x: where.x - point.width / 2, y: where.y - point.height / 2, width: point.width, height: point.height, rx: 7 };
  group.append(drawn("rect", chip), drawn("text", { x: where.x, y: where.y, "font-size": LETTERS_PX }, point.name));
  return group;
}

const chip = (name) => ({ width: LETTERS_PX * (0.62 * name.length + 0.7), height: LETTERS_PX * 1.3 });

// `active`: the configuration of now; `status` by configuration; `words`: what the instrument is called.
export function drawScene(svg, scene, { active, status, words }, whole) {
  svg.setAttribute("viewBox", `0 0 ${whole.width} ${whole.height}`);
  const size = { ...whole, height: whole.height - CAPTION_PX };
  const from = scene.instrument_mm;
  const framed = [...scene.arm_mm, ...scene.fixed_nests.map((nest) => nest.position_mm), ...scene.stops.map((one) => one.position_mm), ...(from ? [from] : []), ...(scene.better ? [scene.better.position_mm] : [])];
  const see = camera(scene, framed, size.width, size.height);
  const nests = scene.fixed_nests.map((nest) => ({ ...see(nest.position_mm), ...nest, kind: "cup", radius: 11, ...chip(nest.name) }));
  const stops = scene.stops.map((one) => ({ at: see(one.position_mm), one, active: one.config === active }));
  const named = [...nests, ...(from ? [{ ...see(from), name: words.instrument, kind: "moment", radius: 34, ...chip(words.instrument) }] : [])];
  if (scene.better) named.push({ ...see(scene.better.position_mm), name: words.better, kind: "nest", radius: 34, ...chip(words.better) });
  const beams = from ? [...nests, ...stops.filter(({ active: now }) => now).map(({ at }) => at)].map((end) => [see(from), end]) : [];
  const tags = placed(named, beams.map((line) => ({ line, thickness: 6 })), size);
  svg.replaceChildren(...[
    ground(scene, see), arm(scene.arm_mm, see),
    ...beams.map((line, i) => drawn("path", { class: `beam${nests[i]?.hidden ? " hidden" : ""}`, d: path(line) })),
    ...stops.map(({ at, one, active: now }) => stop(at, { hidden: one.hidden, status: status.get(one.config), active: now })),
    ...nests.map((nest) => drawn("circle", { class: `fixed${nest.hidden ? " hidden" : ""}`, cx: nest.x, cy: nest.y, r: 9 })),
    from ? head(see(from)) : null,
    scene.better ? drawn("g", { class: "better" }, head(see(scene.better.position_mm))) : null,
    ...named.map((point, i) => tag(point, tags[i])),
  ].filter(Boolean));
}
