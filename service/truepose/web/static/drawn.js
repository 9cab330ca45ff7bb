// What is being drawn while the page is read comes in its place once it is there.

import { refusal } from "./person.js";
import { letKeysScroll } from "./shell.js";

const part = document.querySelector("[data-drawing]");

async function whole() {
  const address = new URL(location.href);
  address.searchParams.set("whole", "true");
  const reply = await fetch(address, { headers: { Accept: "text/html" } }).catch(() => null);
  if (!reply) throw new Error(part.dataset.unreachable);
  if (!reply.ok) throw new Error(await refusal(await reply.json()));
  return new DOMParser().parseFromString(await reply.text(), "text/html").getElementById("drawn");
}

try {
  part.replaceWith(await whole());
  letKeysScroll();
} catch (error) {
  const said = part.querySelector("[role=status]");
  said.className = "warning";
  said.textContent = error.message;
}
