// The form that takes a program: what it asks is the API's own, and the page of the correction comes next.

import { answered, filled, followed, onSubmit } from "./api.js";

const form = document.querySelector("#correct");

function addressOf(fields) {
  const options = new URLSearchParams();
  for (const option of fields.querySelectorAll("[data-option]")) {
    if (option.value) options.append(option.name, option.value);
  }
  for (const line of fields.elements.define.value.split("\n")) {
    if (line.trim()) options.append("define", line.trim());
  }
  return `/api/v1/models/${fields.elements.model_id.value}/corrections?${options}`;
}

function filesOf(fields) {
  const files = new FormData();
  for (const name of ["file", "beside"]) {
    for (const file of fields.elements[name].files) files.append(name, file);
  }
  return files;
}

async function correct(say) {
  const { working, unreachable } = form.dataset;
  say(filled(working, { percent: 0, message: "" }));
  const asked = await answered(addressOf(form), { method: "POST", body: filesOf(form) }, unreachable);
  const told = ({ fraction, message }) => say(filled(working, { percent: Math.round(100 * fraction), message }));
  const job = await followed(asked, unreachable, told, say);
  if (job.state !== "succeeded") throw new Error(job.message);
  location.assign(`/corrections/${job.result_id}`);
}

if (form) onSubmit(form, correct);
