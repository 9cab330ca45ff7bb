// The form that takes a program: what it asks is the API's own, and the page of the correction comes next.

import { answered, filled, onSubmit } from "./api.js";

const POLL_MS = 500;
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
  let job = await answered(addressOf(form), { method: "POST", body: filesOf(form) }, unreachable);
  while (["queued", "running"].includes(job.state)) {
    say(filled(working, { percent: Math.round(100 * job.fraction), message: job.message }));
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    job = await answered(`/api/v1/jobs/${job.id}`, {}, unreachable);
  }
  if (job.state !== "succeeded") throw new Error(job.message);
  location.assign(`/corrections/${job.result_id}`);
}

if (form) onSubmit(form, correct);
