// The upper edge: where the session stands, who acts, what waits, whether the service is heard.

import { showIf, write } from "./elements.js";
import { actsHere, hasEnded } from "./situation.js";
import { buttonShape } from "./shapes.js";

// Where nobody is in the cell no tablet holds the session: `acting` is missing there. `watching` counts this page too.
function who({ acting, watching }, tablet, texts) {
  const others = watching > 1 ? texts.say("who.watching", { count: watching - 1 }) : "";
  if (acting === undefined) return others;
  const acts = !acting ? texts.say("who.nobody")
    : acting.tablet === tablet ? texts.say("who.acts_here")
    : texts.say("who.acts", { person: acting.person });
  return others ? `${acts} · ${others}` : acts;
}

export class Top {
  #at;
  #says;

  // `at`: the elements by id; `says`: { where(session, texts), progress(session, texts), share(session) from 0 to 1 }
  constructor(at, says) {
    this.#at = at;
    this.#says = says;
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
    write(this.#at.units, texts.units.symbol("mm"));
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
    write(at.where, this.#says.where(session, texts));
    write(at.who, who(session, tablet.id, texts));
    write(at.progress, this.#says.progress(session, texts));
    at.done.style.width = `${100 * Math.min(1, this.#says.share(session))}%`;
    const here = actsHere(session, tablet.id);
    showIf(at["take-over"], !here && !hasEnded(session));
    at["take-over"].disabled = !up;
    showIf(at.watches, !here && !hasEnded(session));
    write(at.watches, texts.say("who.not_here"));
  }
}
