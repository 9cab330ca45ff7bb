// The middle of the screen: what is asked, the picture, what was stored last, the length.

import { element, drawn, showIf, write } from "../common/elements.js";
import { showEnd, showOverview } from "./overview.js";
import { drawPicture } from "./picture.js";
import { placeInNumbers } from "./place.js";
import { reasonInWords } from "../common/reasons.js";
import { READ } from "./situation.js";
import { pairInWords, pointsOf, wordsOf } from "./words.js";

const CHECKS = ["move.check_people", "move.check_bar", "move.check_stop"];
const BALL = ["fit_ball", "remove_ball"]; // the setting ball sits in tool nest 1
const ENDS = ["finished", "aborted", "failed"];
const RESTS = ["paused", "interrupted"]; // screens that say why nothing goes on
const UNSEEN = ["planned", ...ENDS]; // screens without a picture
const BAR = "M2 20H78M18 20H54"; // the ballbar between two names

function nameBlocks(points) {
  const block = (name) => element("span", { class: name.startsWith("B") ? "cup" : "nest" }, name);
  const bar = () => drawn("svg", { class: "between", viewBox: "0 0 80 40", "aria-hidden": "true" }, drawn("path", { d: BAR }), drawn("path", { class: "tube", d: "M20 20H52" }));
  return points.flatMap((name, i) => (i ? [bar(), block(name)] : [block(name)]));
}

function doubtInWords({ step, suspicion }, texts) {
  const pair = suspicion.suspected && pairInWords(suspicion.suspected);
  const asked = step.points ? pairInWords(step.points) : texts.say("initialise.names");
  const expected = suspicion.expected_mm !== null && texts.units.length(suspicion.expected_mm, texts);
  const said = { pair, asked, expected };
  const keys = {
    same_pair: pair ? "doubt.same_pair" : "doubt.same_pair_unknown",
    other_pair: "doubt.other_pair",
    exchanged: "doubt.exchanged",
    calibrator: "doubt.calibrator",
    like_calibrator: "doubt.like_calibrator",
    same_connection: pair ? "doubt.same_connection" : "doubt.same_connection_unknown",
    not_calibrator: "doubt.not_calibrator",
    same_bars: "doubt.same_bars",
    unlikely: expected ? "doubt.unlikely" : "doubt.unlikely_plain",
  };
  const read = { pair: asked, length: texts.units.length(suspicion.length_mm, texts) };
  return [texts.say("doubt.asked", read), texts.say(keys[suspicion.kind], said)];
}

function caption(screen, points) {
  if (screen === "move" || screen === "moving") return "picture.move";
  if (points.length < 2) return "picture.plain";
  return points[0][0] === points[1][0] ? "picture.side" : "picture.pair";
}

// Points of a step that names none.
function highlighted(step, scene) {
  if (BALL.includes(step.kind)) return ["T1"];
  if (step.kind !== "place_base") return [];
  return scene.points.filter((point) => point.kind === "cup").map((point) => point.name);
}

// The geometry of the present step; null while it is fetched.
function sceneNow({ session, scene, sceneOf }) {
  return sceneOf === session?.step?.id ? scene : null;
}

export class Stage {
  #at;
  #drawn = null;
  #scene = null;
  #panel = { shown: "", steps: null, scene: null };

  constructor(at, redraw) {
    this.#at = at;
    new ResizeObserver(redraw).observe(at.picture);
  }

  show(screen, model, texts) {
    const { session } = model;
    document.body.dataset.screen = screen;
    this.#showWords(screen, session, texts);
    this.#showPanel(screen, model, texts);
    this.#showPicture(screen, model, texts);
    this.#showLast(model, texts);
    showIf(this.#at.last, !UNSEEN.includes(screen));
    showIf(this.#at.gauge, READ.includes(screen));
  }

  #showWords(screen, session, texts) {
    const { kicker, points, names, instruction } = wordsOf(screen, session, texts);
    const at = this.#at;
    write(at.kicker, kicker);
    write(at.instruction, instruction);
    const shown = points.length ? points.join(" ") : (names ?? session.name);
    if (at.names.dataset.shown !== shown) at.names.replaceChildren(...(points.length ? nameBlocks(points) : [shown]));
    at.names.dataset.shown = shown;
    at.names.setAttribute("aria-label", shown);
    at.names.classList.toggle("words", !points.length);
    const unseen = screen === "connect_leg" && !session.swaps_can_be_seen;
    showIf(at.hint, unseen);
    write(at.hint, unseen ? texts.say("hint.swap") : "");
  }

  #showPanel(screen, model, texts) {
    const { panel } = this.#at;
    const { session, steps } = model;
    const scene = sceneNow(model);
    const shown = [screen, session?.step?.id, texts.language, texts.units.name, session?.suspicion?.kind, session?.ballbar_attached, session?.reason, model.up].join();
    const why = RESTS.includes(screen) ? reasonInWords({ ...session, question: null }) : null;
    const placing = screen === "place_base" && scene !== null;
    showIf(panel, ["planned", "move", "doubt", ...ENDS].includes(screen) || why !== null || placing);
    if (this.#panel.shown === shown && this.#panel.steps === steps && this.#panel.scene === scene) return;
    this.#panel = { shown, steps, scene };
    if (ENDS.includes(screen)) showEnd(panel, session, steps, texts);
    else if (screen === "planned") showOverview(panel, session, steps, texts);
    else if (screen === "move") panel.replaceChildren(...this.#checks(model, texts));
    else if (screen === "doubt") panel.replaceChildren(...doubtInWords(session, texts).map((text) => element("p", {}, text)));
    else if (why) panel.replaceChildren(why);
    else if (placing) panel.replaceChildren(...placeInNumbers(scene, texts));
    else panel.replaceChildren();
  }

  #checks({ session, up }, texts) {
    const checks = element("ul", { class: "checks" }, ...CHECKS.map((key) => element("li", {}, texts.say(key))));
    const why = session.ballbar_attached ? "move.attached" : up ? null : "move.offline";
    return [checks, why && element("p", { class: "why" }, texts.say(why))].filter(Boolean);
  }

  #showPicture(screen, model, texts) {
    const { picture } = this.#at;
    const { session } = model;
    const scene = sceneNow(model);
    showIf(picture, scene !== null && !UNSEEN.includes(screen));
    const size = { width: picture.clientWidth, height: picture.clientHeight };
    if (picture.hidden || size.width < 50 || size.height < 50) return;
    const points = pointsOf(screen, session);
    const asked = points.length ? points : highlighted(session.step, scene);
    const suspected = session.suspicion?.suspected ?? [];
    const shown = JSON.stringify([session.step.id, screen, asked, suspected, size, texts.language]);
    if (shown === this.#drawn && scene === this.#scene) return;
    this.#drawn = shown;
    this.#scene = scene;
    const svg = picture.querySelector("svg");
    const words = { now: texts.say("picture.now"), then: texts.say("picture.then"), robot: texts.say("picture.robot") };
    drawPicture(svg, scene, { asked, suspected, words }, size);
    const [first, second] = asked;
    svg.setAttribute("aria-label", texts.say(caption(screen, asked), { first, second }));
  }

  #showLast({ session, stepsById, stored, storedNow }, texts) {
    const { last } = this.#at;
    last.classList.toggle("fresh", stored !== null && storedNow);
    if (!stored) return write(last, session ? texts.say("stored.none") : "");
    const step = stepsById.get(stored.step_id);
    const what = step?.points ? pairInWords(step.points) : texts.say("initialise.names");
    const length = texts.units.length(stored.length_mm, texts);
    return write(last, texts.say(storedNow ? "stored.now" : "stored.last", { what, length }));
  }
}
