// Closes a session with what the form says; the page then shows what was kept.

import { onSubmit, post } from "./api.js";

const form = document.querySelector("#close");

async function close() {
  await post(form.dataset.path, Object.fromEntries(new FormData(form)), form.dataset.unreachable);
  location.reload();
}

if (form) onSubmit(form, close);
