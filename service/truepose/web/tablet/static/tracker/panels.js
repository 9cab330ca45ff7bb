// What stands beside the picture: who and what, the nests, drift, what the readings promise, what was left out.

import { element } from "../common/elements.js";

const KINDS = { tracker: "device.tracker", robot: "device.robot", pose_tracker: "device.camera", linear_gauge: "device.gauge", ballbar: "device.ballbar" };
const HIDDEN = { turned_away: "hidden.turned_away", behind_column: "hidden.behind_column", too_steep: "hidden.too_steep", too_near: "hidden.too_near" };

const line = (name, value, more) => element("div", { class: "fact" }, element("dt", {}, name), element("dd", {}, value, more ? element("small", {}, more) : null));

// Who acts, which robot, tool and instruments, and what certifies them.
export function whoAndWhat({ session, devices, tablet }, texts) {
  const tool = session.tool || texts.say("who_what.tool_unnamed");
  const facts = [
    line(texts.say("who_what.operator"), tablet.person ?? texts.say("name.none")),
    line(texts.say("who_what.robot"), session.robot, session.robot_serial_number ? texts.say("who_what.serial", { serial: session.robot_serial_number }) : null),
    line(texts.say("who_what.tool"), tool, texts.say("who_what.mounting", { attachment: session.attachment })),
    ...devices.filter((device) => used(device, session)).map((device) => deviceLine(device, texts)),
    line(texts.say("who_what.plan"), texts.say("who_what.configurations", { planned: session.progress.planned }), session.warm_up ? texts.say("who_what.warm_up") : null),
  ];
  const checklist = element("a", { class: "main plain link-button", href: `/sessions/${session.id}/checklist` }, texts.say("overview.checklist"));
  return [element("dl", { class: "facts-list" }, ...facts), checklist];
}

// What a session with a tracker uses is not the ballbar, nor the other way round.
function used({ kind }, session) {
  const instrument = { tracker: "tracker", camera: "pose_tracker", contacts: "linear_gauge" }[session.kind];
  return kind === instrument || kind === "robot";
}

function deviceLine(device, texts) {
  const serial = device.answered_serial_number ?? device.expected_serial_number;
  const name = [device.manufacturer, device.model].filter(Boolean).join(" ") || texts.say("device.not_asked");
  const said = [serial && texts.say("who_what.serial", { serial }), device.kind !== "robot" && certificate(device, texts)];
  return line(texts.say(KINDS[device.kind]), name, said.filter(Boolean).join(" · "));
}

function certificate(device, texts) {
  const { certificate, certificate_expires: expires } = device;
  if (!certificate) return texts.say("device.no_certificate");
  if (!expires) return texts.say("device.certificate", { certificate });
  const day = new Date(expires).toLocaleDateString(texts.language);
  const over = new Date(`${expires}T23:59:59`) < new Date();
  return texts.say(over ? "device.certificate_over" : "device.certificate_until", { certificate, day });
}

// How many configurations are seen, why others are not, and from where more would be.
export function sight(scene, texts, units) {
  const hidden = scene.stops.filter((stop) => stop.hidden);
  const seen = scene.stops.length - hidden.length;
  const whys = Object.keys(HIDDEN).map((why) => [why, hidden.filter((stop) => stop.hidden === why).map((stop) => stop.config)]).filter(([, configs]) => configs.length);
  const blind = scene.fixed_nests.filter((nest) => nest.hidden);
  return [
    element("p", { class: `verdict ${hidden.length || blind.length ? "not" : "good"}` }, texts.say("placing.seen", { seen, all: scene.stops.length })),
    ...whys.map(([why, configs]) => element("p", {}, texts.say(HIDDEN[why], { configs: texts.list(configs) }))),
    ...blind.map((nest) => element("p", {}, texts.say(HIDDEN[nest.hidden], { configs: nest.name }))),
    scene.better ? element("p", { class: "advise" }, betterInWords(scene, texts, units)) : element("p", {}, texts.say("placing.good_enough")),
    element("p", { class: "quiet" }, texts.say("placing.limits")),
  ];
}

function betterInWords({ better, instrument_mm }, texts, units) {
  const [x, y, z] = better.position_mm.map((value, i) => units.signed(value - instrument_mm[i], texts, "coarse"));
  return texts.say("placing.better", { x, y, z, unit: units.symbol("mm"), seen: better.configurations });
}

// Each fixed nest: where the certificate has it, what was read, how it scatters.
export function nestTable({ nests, placed }, reading, texts, units) {
  const heads = ["nests.nest", "nests.expected", "nests.read", "nests.delta", "nests.scatter"];
  const head = element("tr", {}, ...heads.map((key) => element("th", { scope: "col" }, texts.say(key, { unit: units.symbol("mm") }))));
  const rows = nests.map((nest) => {
    const expected = nest.expected_mm.map((value) => units.number(value, texts, "coarse")).join("  ");
    const delta = nest.delta_mm === null ? "" : units.small(Math.hypot(...nest.delta_mm), texts);
    const scatter = nest.scatter_mm === null ? "" : units.small(nest.scatter_mm, texts);
    const cells = [expected, nest.readings ? String(nest.readings) : "", delta, scatter].map((value) => element("td", {}, value));
    return element("tr", { class: nest.number === reading ? "active" : null }, element("th", { scope: "row" }, `F${nest.number}`), ...cells);
  });
  const table = element("table", { class: "nests" }, element("thead", {}, head), element("tbody", {}, ...rows));
  const said = placed?.rms_mm !== null && placed ? element("p", { class: "verdict good" }, texts.say("nests.placed", { rms: units.small(placed.rms_mm, texts) })) : null;
  return [table, said].filter(Boolean);
}

// What the newest look at the fixed nests said.
export function driftInWords(looks, texts, units) {
  const look = looks.at(-1);
  if (!look) return null;
  const nest = look.moved_mm.indexOf(look.worst_mm) + 1;
  const values = { nest, moved: units.small(look.worst_mm, texts), limit: units.small(look.limit_mm, texts), count: looks.length };
  return element("p", { class: `verdict ${look.holds ? "good" : "not"}` }, texts.say(look.holds ? "drift.holds" : "drift.moved", values));
}

export function warmthInWords(warmth, texts, units) {
  if (!warmth || warmth.bound_mm === null) return [element("p", { class: "verdict" }, texts.say("warm.too_early", { rounds: warmth?.time_s.length ?? 0 }))];
  const values = { ahead: units.small(warmth.ahead_mm, texts), bound: units.small(warmth.bound_mm, texts), allowed: units.small(warmth.allowed_mm, texts) };
  return [
    element("p", { class: `verdict ${warmth.ready ? "good" : "not"}` }, texts.say(warmth.ready ? "warm.ready" : "warm.not_yet")),
    element("p", {}, texts.say("warm.drifts", values)),
  ];
}

// What accuracy the readings so far promise, and what the rest will bring.
export function outlookInWords(outlook, texts, units) {
  if (outlook?.state !== "known") return null;
  const { now, at_end } = outlook;
  const said = { mean: units.length(now.mean_mm, texts), n: now.configurations, end: units.length(at_end.mean_mm, texts), all: at_end.configurations };
  return element("p", { class: "outlook" }, texts.say(at_end.configurations > now.configurations ? "outlook.goes_on" : "outlook.done", said));
}

export function leftOut(points, texts) {
  const missing = points.filter(({ status }) => ["failed", "left_out"].includes(status));
  if (!missing.length) return [element("p", { class: "verdict good" }, texts.say("ended.none_skipped"))];
  const rows = missing.map((point) => element("li", {}, element("b", {}, String(point.config)), element("span", {}, point.reason)));
  return [element("h2", {}, texts.say("ended.skipped")), element("ul", { class: "left-out" }, ...rows)];
}

export function afterwards(session, texts) {
  const measured = session.progress.done > 0;
  return [
    ...(measured ? [element("a", { class: "main link-button", href: `/sessions/${session.id}` }, texts.say("ended.result"))] : []),
    element("a", { class: "main plain link-button", href: "/operator" }, texts.say("ended.sessions")),
  ];
}
