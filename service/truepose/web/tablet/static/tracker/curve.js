// The warm-up: how far the fixed nests have seemed to move since it began, and what is allowed.

import { drawn } from "../common/elements.js";

const LEFT = 74, RIGHT = 18, TOP = 20, BOTTOM = 44;
const LETTERS = 17;
const MINUTE_S = 60;

const nice = (span, most) => [1, 2, 5, 10, 15, 20, 30, 60, 120].find((step) => span / step <= most) ?? span / most;

export function drawCurve(svg, warmth, { width, height }, { texts, units }) {
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const minutes = warmth.time_s.map((time) => time / MINUTE_S);
  const last = Math.max(...minutes, 5);
  const most_mm = Math.max(...warmth.drift_mm, 2 * warmth.allowed_mm) * 1.1;
  const x = (minute) => LEFT + ((width - LEFT - RIGHT) * minute) / last;
  const y = (drift_mm) => height - BOTTOM - ((height - TOP - BOTTOM) * drift_mm) / most_mm;
  const line = minutes.map((minute, i) => `${i ? "L" : "M"}${x(minute).toFixed(1)} ${y(warmth.drift_mm[i]).toFixed(1)}`).join("");
  const half = minutes.length >= 8 ? x(minutes[Math.max(0, minutes.length - Math.max(8, minutes.length >> 1))]) : null;
  const judged = half === null ? null : drawn("rect", { class: "judged", x: half, y: TOP, width: x(minutes.at(-1)) - half, height: height - TOP - BOTTOM });
  svg.replaceChildren(...[
    judged, ...grid(last, most_mm, { x, y }, { width, height }, texts, units),
    drawn("path", { class: "drift", d: line || "M0 0" }),
    ...minutes.map((minute, i) => drawn("circle", { class: "reading", cx: x(minute), cy: y(warmth.drift_mm[i]), r: 4 })),
  ].filter(Boolean));
}

function grid(last, most_mm, { x, y }, { width, height }, texts, units) {
  const marks = [];
  const step = nice(last, 6);
  for (let minute = 0; minute <= last + 1e-9; minute += step)
    marks.push(drawn("text", { class: "tick", x: x(minute), y: height - BOTTOM + 22, "font-size": LETTERS }, texts.number(minute, 0)));
  for (const share of [0, 0.5, 1]) {
    const drift_mm = (share * most_mm) / 1.1;
    marks.push(drawn("path", { class: "line", d: `M${LEFT} ${y(drift_mm)}H${width - RIGHT}` }));
    marks.push(drawn("text", { class: "tick end", x: LEFT - 8, y: y(drift_mm) + 5, "font-size": LETTERS }, units.small(drift_mm, texts)));
  }
  marks.push(drawn("text", { class: "tick", x: (LEFT + width - RIGHT) / 2, y: height - 6, "font-size": LETTERS }, texts.say("warm.minutes")));
  return marks;
}
