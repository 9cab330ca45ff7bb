// What nobody finished is thrown away by its button.

import { answered } from "./api.js";
import { inPage } from "./page-part.js";

document.addEventListener("click", async (event) => {
  const number = event.target.dataset.throwAway;
  if (!number) return;
  event.target.disabled = true;
  const { unreachable } = document.querySelector("[data-bring]").dataset;
  try {
    await answered(`/api/v1/drafts/${number}`, { method: "DELETE" }, unreachable);
    await inPage("main", unreachable);
  } catch (error) {
    event.target.disabled = false;
    document.querySelector("[data-bring] output").textContent = error.message;
  }
});
