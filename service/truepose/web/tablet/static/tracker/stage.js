// The middle of the screen: what is asked, the board (picture, curve, table), the panel beside it.

import { element, showIf, write } from "../common/elements.js";
import { drawCurve } from "./curve.js";
import { afterwards, driftInWords, leftOut, nestTable, outlookInWords, sight, warmthInWords, whoAndWhat } from "./panels.js";
import { drawScene } from "./picture.js";
import { Table } from "./table.js";
import { whyInWords, wordsOf } from "./words.js";

const ENDS = ["finished", "aborted", "failed"];
const WATCHED = ["measure", "nests", "look", "warm"];
const PICTURED = ["who", "place", "opening", "nests", "look", "ask", "handwork", "paused", "pausing", "measure", "foreign"];
const TABLED = ["measure", "paused", ...ENDS];

export class Stage {
  #at;
  #panel = "";
  #drawn = "";

  // `on`: { redraw(), chosen() }
  constructor(at, on) {
    this.#at = at;
    this.table = new Table(at.rows, on);
    for (const place of [at.picture, at.curve]) new ResizeObserver(on.redraw).observe(place);
  }

  show(screen, model, texts, units) {
    const { session, sheet } = model;
    document.body.dataset.screen = screen;
    document.body.dataset.kind = session?.kind ?? "";
    this.#showWords(screen, session, texts);
    showIf(this.#at.watch, WATCHED.includes(screen) && session.kind === "tracker");
    this.#showPanel(screen, model, texts, units);
    const tabled = TABLED.includes(screen) && sheet !== null;
    showIf(this.#at.rows, tabled);
    showIf(this.#at.curve, screen === "warm" && sheet?.warmth != null);
    showIf(this.#at.picture, PICTURED.includes(screen) && model.scene !== null);
    showIf(this.#at.board, !(this.#at.rows.hidden && this.#at.curve.hidden && this.#at.picture.hidden));
    if (tabled) this.table.show(sheet.points, session.step?.config ?? null, { texts, units });
    this.#drawPicture(model, texts);
    this.#drawCurve(model, texts, units);
    this.#showLast(screen, model, texts);
  }

  #showWords(screen, session, texts) {
    const { kicker, names, instruction } = wordsOf(screen, session, texts);
    write(this.#at.kicker, kicker);
    write(this.#at.names, names);
    write(this.#at.instruction, instruction);
  }

  #showPanel(screen, model, texts, units) {
    const { session, sheet, scene, devices, outlook, sample, tablet } = model;
    const counts = sheet && screen !== "measure" ? sheet : [sheet?.looks.length, outlook];
    const shown = JSON.stringify([screen, texts.language, units.name, session, counts, scene?.stops, scene?.better, devices, sample?.fixed_nest, this.table.chosen, tablet.person]);
    if (shown === this.#panel) return;
    this.#panel = shown;
    const parts = this.#parts(screen, model, texts, units).filter(Boolean);
    this.#at.panel.replaceChildren(...parts);
    showIf(this.#at.panel, parts.length > 0);
  }

  #parts(screen, model, texts, units) {
    const { session, sheet, scene, outlook, sample } = model;
    const asked = session && whyInWords(screen, session);
    const drift = sheet && driftInWords(sheet.looks, texts, units);
    const ended = ENDS.includes(screen) && sheet;
    const shown = {
      who: () => whoAndWhat(model, texts),
      place: () => (scene ? sight(scene, texts, units) : []),
      warm: () => warmthInWords(sheet?.warmth, texts, units),
      nests: () => (sheet ? nestTable(sheet, sample?.fixed_nest, texts, units) : []),
      look: () => (sheet ? [drift, ...nestTable(sheet, sample?.fixed_nest, texts, units)] : []),
      paused: () => [this.#choice(texts)],
      measure: () => [this.#choice(texts), outlookInWords(outlook, texts, units), drift],
    };
    return [asked, ...(shown[screen]?.() ?? []), ...(ended ? [...leftOut(sheet.points, texts), drift, ...afterwards(session, texts)] : [])];
  }

  #choice(texts) {
    const { chosen } = this.table;
    return element("p", { class: "choice-words" }, chosen === null ? texts.say("table.choose") : texts.say("table.chosen", { config: chosen }));
  }

  #drawPicture({ session, scene, sheet }, texts) {
    const { picture, caption } = this.#at;
    const size = { width: picture.clientWidth, height: picture.clientHeight };
    if (picture.hidden || size.width < 50 || size.height < 50) return;
    const status = new Map((sheet?.points ?? []).map((point) => [point.config, point.status]));
    const active = session.step?.config ?? null;
    const shown = JSON.stringify([scene, [...status], active, size, texts.language]);
    if (shown === this.#drawn) return;
    this.#drawn = shown;
    const svg = picture.querySelector("svg");
    drawScene(svg, scene, { active, status, words: { instrument: texts.say(session.kind === "camera" ? "picture.camera" : "picture.tracker"), better: texts.say("picture.better") } }, size);
    const hidden = scene.stops.filter((stop) => stop.hidden).length;
    write(caption, texts.say("picture.legend"));
    svg.setAttribute("aria-label", texts.say("picture.guided", { seen: scene.stops.length - hidden, hidden }));
  }

  #drawCurve({ sheet }, texts, units) {
    const { curve } = this.#at;
    const size = { width: curve.clientWidth, height: curve.clientHeight };
    if (curve.hidden || size.width < 50 || size.height < 50) return;
    const svg = curve.querySelector("svg");
    drawCurve(svg, sheet.warmth, size, { texts, units });
    svg.setAttribute("aria-label", texts.say("warm.curve"));
    write(this.#at["curve-words"], texts.say("warm.curve"));
  }

  #showLast(screen, { session, measuredNow }, texts) {
    const { last } = this.#at;
    const stop = session?.last_stop;
    showIf(last, ["measure", "look", "paused", "pausing"].includes(screen));
    last.classList.toggle("fresh", measuredNow && stop?.measured === true);
    const key = stop?.measured ? "last.measured" : "last.failed";
    write(last, stop ? texts.say(key, { config: stop.config, text: stop.text }) : texts.say("last.none"));
  }
}
