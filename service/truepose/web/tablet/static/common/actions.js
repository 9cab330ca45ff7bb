// The large buttons above the dock: what the screen is for.

import { element } from "./elements.js";
import { holdButton } from "/static/hold.js";
import { can, stepOf } from "./situation.js";

// A second tap of a gloved hand, meant for the screen before, must not answer the next one.
const FRESH_MS = 600;

export class Actions {
  #place;
  #on;
  #offer;
  #shown = "";
  #shown_ms = 0;
  #buttons = [];

  // `offer`: { of(screen, session): [{ act, key, held, plain, answer, local }] (`local`: the page does it, whatever the session allows), label(offer, model, texts),
  // nothing(offer, model): why its button has nothing to do, or null, values(session): of the texts, named(session) }
  // `on`: { tapped(act, { answer }), settled() }
  constructor(place, offer, on) {
    this.#place = place;
    this.#offer = offer;
    this.#on = on;
  }

  show(screen, model, texts) {
    const offers = this.#offer.of(screen, model.session);
    // Built anew for a new step only: a finger may rest on a button while the rest of the page changes.
    const { step, prompt } = model.session ?? {};
    const shown = `${screen} ${step?.id} ${prompt?.id ?? ""} ${this.#offer.named(model.session) ?? ""}`;
    if (shown !== this.#shown) this.#begin(shown, offers, texts, this.#offer.values(model.session));
    const fresh = performance.now() - this.#shown_ms < FRESH_MS;
    offers.forEach((offer, i) => this.#draw(this.#buttons[i], offer, fresh, model, texts));
  }

  #draw(button, offer, fresh, model, texts) {
    const idle = this.#offer.nothing(offer, model) !== null;
    const offered = Boolean(offer.act) && (offer.local || can(model, offer.act)) && !idle;
    // What must be held is no second tap.
    const early = fresh && !offer.held;
    button.disabled = early || !offered;
    button.classList.toggle("fresh", early && offered);
    button.classList.toggle("idle", idle);
    const text = button.classList.contains("holding") ? texts.say("act.hold_more") : this.#label(offer, model, texts);
    if (button.lastChild.textContent !== text) button.lastChild.textContent = text;
  }

  #label(offer, model, texts) {
    const why = this.#offer.nothing(offer, model);
    if (why) return texts.say(why);
    if (offer.act && model.queue.holds(offer.act, stepOf(model.session, offer.act))) return texts.say("queue.waits");
    return this.#offer.label(offer, model, texts);
  }

  #begin(shown, offers, texts, values) {
    this.#shown = shown;
    this.#shown_ms = performance.now();
    this.#buttons = offers.map((offer) => this.#button(offer, texts, values));
    this.#place.replaceChildren(...this.#buttons);
    setTimeout(() => this.#on.settled(), FRESH_MS + 1);
  }

  #button(offer, texts, values) {
    const kind = offer.held ? "main hold" : `main${offer.plain ? " plain" : ""}`;
    const fill = element("i", { class: "fill", "aria-hidden": "true" });
    const button = element("button", { type: "button", class: kind, "data-act": offer.act }, fill, element("span"));
    const tapped = () => this.#on.tapped(offer.act, { answer: offer.answer });
    const text = (holding) => texts.say(holding ? "act.hold_more" : offer.key, values);
    if (!offer.held) button.addEventListener("click", tapped);
    else holdButton(button, { held: tapped, changed: (holding) => (button.lastChild.textContent = text(holding)) });
    return button;
  }
}
