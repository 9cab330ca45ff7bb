// Questions the page itself asks. They lie over the picture and never over the dock: STOP stays in reach.

import { element } from "./elements.js";
import { isTaken, same } from "./people.js";

// The service's own sentence, beside what it is about.
const refusal = (sentence) => (sentence ? element("p", { class: "refused", id: "refused", role: "alert", lang: "en" }, sentence) : null);

export class Dialogues {
  #place;
  #texts;
  #before = null;
  #ask = null;

  constructor(place, texts) {
    this.#place = place;
    this.#texts = texts;
    place.addEventListener("keydown", (event) => event.key === "Escape" && this.close());
  }

  get open() {
    return !this.#place.hidden;
  }

  close() {
    if (!this.open || this.#ask?.must) return;
    this.leave();
  }

  // Shows the question again, in the language of now.
  again() {
    if (this.open) this.#show();
  }

  // `people`: whom the cell announces; one tap chooses. Else a name is written. Whoever has none may watch.
  name({ present, people, refused }, kept) {
    const known = isTaken(present, people) && !refused;
    const keep = (name) => (this.leave(), kept(name));
    const shared = { must: !known, cancel: known ? "dialogue.cancel" : people.length ? "name.watch" : null };
    if (people.length) return this.put({ ...shared, title: "name.choose", text: refused ? null : "name.choose_text", parts: () => this.#people(people, present, refused, keep) });
    const submitted = (form) => {
      const name = form.elements.person.value.trim();
      if (name) keep(name);
    };
    return this.put({ ...shared, title: "name.title", text: "name.text", parts: () => this.#written(present, refused), does: "name.keep", submitted });
  }

  #people(people, present, refused, keep) {
    const choice = (name) =>
      element("button", { type: "button", class: "person", "aria-pressed": same(present, name) ? "true" : "false", onclick: () => keep(name) }, name);
    return [refusal(refused), element("div", { class: "people" }, ...people.map(choice))];
  }

  #written(present, refused) {
    const input = element("input", { name: "person", value: present ?? "", maxlength: 100, required: true, autocomplete: "name",
      "aria-invalid": refused ? "true" : "false", "aria-describedby": refused ? "refused" : null });
    return [element("label", { class: "field" }, this.#texts.say("name.label"), input), refusal(refused)];
  }

  // `ask`: { title, text, values, reasons: keys, given: the one that is chosen already }; `other` takes what is written.
  reasoned({ reasons, given, other, ...ask }, chosen) {
    const submitted = (form) => {
      const key = form.elements.reason.value;
      const written = form.elements.written.value.trim();
      if (!key || (key === other && !written)) return form.elements.written.focus();
      this.leave();
      return chosen([key === other ? "" : this.#texts.record(key), written].filter(Boolean).join(": "));
    };
    this.put({ ...ask, parts: () => this.#reasons(reasons, given, other), submitted });
  }

  // Nothing shows that the ballbar is off: a person says how they know.
  off(written) {
    const submitted = (form) => {
      const said = form.elements.written.value.trim();
      if (!said) return form.elements.written.focus();
      this.leave();
      return written(said);
    };
    const parts = () => [this.field("off.write", { name: "written", maxlength: 300, required: true })];
    this.put({ title: "off.title", text: "off.text", parts, does: "off.do", submitted });
  }

  abort(meant) {
    this.put({ title: "abort.title", text: "abort.text", parts: () => [], does: "abort.do", danger: true,
      submitted: () => (this.leave(), meant()) });
  }

  takeOver(person, meant) {
    const text = person ? "who.take_text" : "who.take_nobody";
    this.put({ title: "who.take_title", text, values: { person }, parts: () => [], does: "who.take_over",
      submitted: () => (this.leave(), meant()) });
  }

  #reasons(offered, given, other) {
    const choice = (key) =>
      element("label", { class: "choice" },
        element("input", { type: "radio", name: "reason", value: key, required: true, checked: key === given }),
        element("span", {}, this.#texts.say(key)));
    const written = element("input", { name: "written", maxlength: 300, "aria-label": this.#texts.say("skip.write"), placeholder: this.#texts.say("skip.write") });
    written.addEventListener("input", () => this.#place.querySelector("input:checked") ?? (this.#place.querySelector(`[value="${other}"]`).checked = true));
    return [element("div", { class: "reasons" }, ...offered.map(choice)), element("label", { class: "field" }, written)];
  }

  field(label, attributes) {
    return element("label", { class: "field" }, this.#texts.say(label), element("input", attributes));
  }

  // Asks something: `parts()` are its fields, `submitted(form)` takes them.
  put(ask) {
    this.#ask = ask;
    this.#before = document.activeElement;
    this.#show();
  }

  #show() {
    const { title, text, values, parts, does, danger, cancel = "dialogue.cancel", submitted } = this.#ask;
    const say = (key) => this.#texts.say(key, values);
    const buttons = [
      cancel && element("button", { type: "button", class: "main plain", onclick: () => this.leave() }, say(cancel)),
      does ? element("button", { class: danger ? "main danger" : "main" }, say(does)) : null,
    ];
    const form = element("form", { novalidate: true },
      element("h2", { id: "dialogue-title" }, say(title)), text ? element("p", {}, say(text)) : null,
      ...parts(), element("div", { class: "answers" }, ...buttons));
    form.addEventListener("submit", (event) => (event.preventDefault(), submitted?.(form)));
    this.#place.replaceChildren(form);
    this.#place.hidden = false;
    (form.querySelector("input[name=person]") ?? this.#place).focus();
  }

  leave() {
    this.#place.hidden = true;
    this.#place.replaceChildren();
    this.#before?.focus?.();
  }
}
