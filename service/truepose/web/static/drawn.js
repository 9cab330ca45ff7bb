// What is being drawn while the page is read comes in its place once it is there.

import { answerTo } from "./api.js";
import { inPage } from "./page-part.js";
import { letKeysScroll } from "./shell.js";

const part = document.querySelector("[data-drawing]");
const whole = new URL(location.href);
whole.searchParams.set("whole", "true");

function say(sentence) {
  const said = part.querySelector("[role=status]");
  said.className = "warning";
  said.textContent = sentence;
}

try {
  await answerTo(() => inPage("#drawn", part.dataset.unreachable, whole), say);
  letKeysScroll();
} catch (error) {
  say(error.message);
}
