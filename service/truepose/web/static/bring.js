// What nobody finished is thrown away by its button.

import { inPage } from "./page-part.js";

document.addEventListener("click", async (event) => {
  const number = event.target.dataset.throwAway;
  if (!number) return;
  event.target.disabled = true;
  await fetch(`/api/v1/drafts/${number}`, { method: "DELETE" });
  await inPage("main");
});
