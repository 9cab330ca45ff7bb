// Why nothing goes on: the service says it in the language of the page.

import { element } from "./elements.js";

const TITLED = "session.pause_asked"; // the title says so

// Returns a paragraph, or null where the screen says it all.
export function reasonInWords({ question, reason, reason_key }) {
  const said = question ?? reason;
  return said && (question || reason_key !== TITLED) ? element("p", { class: "reason" }, said) : null;
}
