// The upper edge: where the session stands, who acts, what waits, whether the service is heard.

import { showIf, write } from "./elements.js";
import { actsHere, hasEnded } from "./situation.js";
import { buttonShape } from "./shapes.js";

const SOON_S = 45;

function where({ step, state }, texts) {
  if (!step || state === "planned") return "";
  const said = [texts.say("top.step", { index: step.index, count: step.count })];
  if (step.placement !== null) said.push(texts.say("top.placement", { placement: step.placement }));
  if (step.leg_number) said.push(texts.say("top.leg", { config: step.config, leg: step.leg_number, legs: step.leg_count }));
  else if (step.config !== null) said.push(texts.say("top.pose", { config: step.config }));
  if (step.attempt > 1) said.push(texts.say("top.again", { attempt: step.attempt }));
  return said.join(", ");
}

function who({ acting, watching }, tablet, texts) {
  const acts = !acting ? texts.say("who.nobody")
    : acting.tablet === tablet ? texts.say("who.acts_here")
    : texts.say("who.acts", { person: acting.person });
  return `${acts} · ${texts.say("who.watching", { count: watching })}`;
}

function remaining(seconds, texts) {
  return seconds < SOON_S ? texts.say("progress.soon") : texts.say("progress.left", { time: texts.duration(seconds) });
}

function progress(session, texts) {
  const done = session.progress;
  const said = [texts.say("progress.readings", { readings: done.readings, planned: done.planned })];
  if (done.remaining_s !== null && !hasEnded(session)) said.push(remaining(done.remaining_s, texts));
  const skipped = done.skipped_poses;
  if (skipped) said.push(texts.say(skipped === 1 ? "progress.skipped_one" : "progress.skipped_many", { count: skipped }));
  return said.join(" · ");
}

export class Top {
  #at;

  // `at`: the elements by id
  constructor(at) {
    this.#at = at;
  }

  show(model, texts) {
    this.#showLink(model, texts);
    this.#showTablet(model.tablet, texts);
    this.#showTaps(model, texts);
    if (model.session) this.#showSession(model, texts);
  }

  #showLink({ up, opened }, texts) {
    const state = up ? "up" : opened ? "lost" : "opening";
    const words = { up: "link.up", lost: "link.lost", opening: "link.opening" };
    this.#at.link.dataset.state = state;
    write(this.#at.link, texts.say(words[state]));
    showIf(this.#at.lost, state === "lost");
    // Said anew each time it is lost: a screen reader speaks what changes.
    write(this.#at.lost, state === "lost" ? texts.say("lost.banner") : "");
  }

  #showTablet(tablet, texts) {
    write(this.#at.person, tablet.person ?? texts.say("name.none"));
    this.#at.person.setAttribute("aria-label", texts.say("name.change", { person: tablet.person ?? texts.say("name.none") }));
    const { mute } = this.#at;
    if (mute.dataset.muted !== String(tablet.muted)) mute.replaceChildren(buttonShape(tablet.muted ? "silent" : "sound"));
    mute.dataset.muted = tablet.muted;
    mute.setAttribute("aria-pressed", tablet.muted);
    mute.setAttribute("aria-label", texts.say(tablet.muted ? "top.unmute" : "top.mute"));
  }

  #showTaps({ queue, up }, texts) {
    const count = queue.taps.length;
    const shown = count > 0 && !up;
    showIf(this.#at.queued, shown);
    write(this.#at.queued, shown ? texts.say(count === 1 ? "queue.one" : "queue.many", { count }) : "");
    this.#at.queued.dataset.count = count;
  }

  #showSession({ session, tablet, up }, texts) {
    const at = this.#at;
    write(at["session-name"], session.name);
    write(at.where, where(session, texts));
    write(at.who, who(session, tablet.id, texts));
    write(at.progress, progress(session, texts));
    const { readings, planned } = session.progress;
    at.done.style.width = `${planned ? Math.min(100, (100 * readings) / planned) : 0}%`;
    const here = actsHere(session, tablet.id);
    showIf(at["take-over"], !here && !hasEnded(session));
    at["take-over"].disabled = !up;
    showIf(at.watches, !here && !hasEnded(session));
    write(at.watches, texts.say("who.not_here"));
  }
}
