// The steps listed beforehand: what will be done, how many readings, how long.

import { element } from "../common/elements.js";
import { READ } from "./situation.js";
import { pairInWords, stepInWords } from "./words.js";

const HEADS = {
  tool: "overview.tool",
  placement: "overview.placement",
  pose: "overview.pose",
  compute: "overview.compute",
};

function group(step) {
  const { placement, config, attempt } = step;
  if (step.kind === "precalibrate") return { head: "compute", placement, config: step.id };
  if (config !== null) return { head: "pose", placement, config: `${config}`, attempt };
  return placement === null ? { head: "tool" } : { head: "placement", placement };
}

// Steps that belong together, in the order of the session.
export function grouped(steps) {
  const groups = [];
  for (const step of steps) {
    const mine = group(step);
    const last = groups.at(-1);
    const same = last && JSON.stringify(last.of) === JSON.stringify(mine);
    if (same) last.steps.push(step);
    else groups.push({ of: mine, steps: [step] });
  }
  return groups;
}

function amounts(steps, texts) {
  const readings = steps.filter((step) => READ.includes(step.kind)).length;
  const counted = (count, one, many) => (count === 1 ? texts.say(one) : texts.say(many, { count }));
  const said = [counted(steps.length, "overview.step", "overview.steps")];
  if (readings) said.push(counted(readings, "overview.reading", "overview.readings"));
  return texts.list(said);
}

function card({ of, steps }, texts) {
  const head = texts.say(HEADS[of.head], of);
  const rows = () => steps.map((step) => element("li", {}, stepInWords(step, texts)));
  const list = element("ol");
  const opened = (event) => event.target.open && !list.children.length && list.append(...rows());
  return element("details", { ontoggle: opened }, element("summary", {}, element("b", {}, head), element("span", {}, amounts(steps, texts))), list);
}

export function showOverview(panel, session, steps, texts) {
  const { planned, remaining_s } = session.progress;
  const facts = { readings: planned, steps: steps.length, time: texts.duration(remaining_s ?? 0) };
  // What somebody opened stays open when the list is drawn anew.
  const opened = [...panel.querySelectorAll("details")].map((one) => one.open);
  const cards = grouped(steps).map((found) => card(found, texts));
  panel.replaceChildren(
    element("p", { class: "facts" }, texts.say("overview.facts", facts)),
    element("a", { class: "main plain link-button", href: `/sessions/${session.id}/checklist` }, texts.say("overview.checklist")),
    element("div", { class: "groups" }, ...cards),
  );
  cards.forEach((one, index) => { one.open = opened[index] === true; });
}

// A pose that was skipped and measured at a later attempt is not left out.
function measuredLater({ config, attempt }, steps) {
  const later = (step) => step.config === config && step.attempt > attempt && step.outcome === "measured";
  return config !== null && steps.some(later);
}

function leftOut({ of, steps }, texts) {
  const named = steps.filter((step) => step.points).map((step) => pairInWords(step.points));
  const what = `${texts.say(HEADS[of.head], of)}: ${texts.list(named) || stepInWords(steps[0], texts)}`;
  return element("li", {}, element("b", {}, what), element("span", {}, steps[0].text ?? ""));
}

// What became of it: how much was measured, what was left out and why.
export function showEnd(panel, session, steps, texts) {
  const { readings, planned, elapsed_s } = session.progress;
  const facts = { readings, planned, time: texts.duration(elapsed_s) };
  const left = grouped(steps.filter((step) => step.outcome === "skipped" && !measuredLater(step, steps)));
  panel.replaceChildren(
    element("p", { class: "facts" }, texts.say("ended.facts", facts)),
    element("h2", {}, texts.say(left.length ? "ended.skipped" : "ended.none_skipped")),
    element("ul", { class: "left-out" }, ...left.map((found) => leftOut(found, texts))),
    ...(readings ? [element("a", { class: "main link-button", href: session.result_url }, texts.say("ended.result"))] : []),
    element("a", { class: "main plain link-button", href: "/operator" }, texts.say("ended.sessions")),
  );
}
