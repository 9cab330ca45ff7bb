// Files that are dropped or chosen: sent one after the other as they are, with how far it is; then their page opens.

import { filled, post } from "./api.js";

const HIDDEN = /(^|\/)(\.|__MACOSX|~\$|Thumbs\.db)/;

// A page of something between here and the service says nothing of the file.
function refusedIn(text) {
  try {
    return JSON.parse(text).detail;
  } catch {
    return undefined;
  }
}

function sent(address, file, told, unreachable) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();  // fetch does not say how much has gone
    request.open("POST", address);
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.upload.onprogress = (event) => told(event.loaded);
    request.onerror = () => reject(new Error(unreachable));
    request.onload = () => (request.status < 300 ? resolve() : reject(new Error(refusedIn(request.responseText) ?? unreachable)));
    request.send(file);
  });
}

// A folder is walked through; a browser hands out its entries a hundred at a time.
async function within(entry, path = "") {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    return [{ file, name: path + file.name }];
  }
  const reader = entry.createReader();
  const found = [];
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return found;
    for (const one of some) found.push(...await within(one, `${path}${entry.name}/`));
  }
}

async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.length) return [...transfer.files].map((file) => ({ file, name: file.name }));
  return (await Promise.all(entries.map((entry) => within(entry)))).flat();
}

function chosen(input) {
  return [...input.files].map((file) => ({ file, name: file.webkitRelativePath || file.name }));
}

async function bring(area, files) {
  const { draft, receiving, nothing, reading, unreachable } = area.dataset;
  const output = area.querySelector("output");
  const line = area.querySelector(".progress");
  const wanted = files.filter(({ name }) => !HIDDEN.test(name));
  output.classList.remove("bad");
  try {
    if (!wanted.length) throw new Error(nothing);
    const number = draft || (await post("/api/v1/drafts", {}, unreachable)).id;
    const total = wanted.reduce((sum, { file }) => sum + file.size, 0) || 1;
    let before = 0;
    line.hidden = false;
    for (const { file, name } of wanted) {
      const told = (bytes) => {
        line.firstElementChild.value = (before + bytes) / total;
        output.textContent = filled(receiving, { percent: Math.round((100 * (before + bytes)) / total), name });
      };
      told(0);
      await sent(`/api/v1/drafts/${number}/files?name=${encodeURIComponent(name)}`, file, told, unreachable);
      before += file.size;
    }
    output.textContent = reading;
    if (draft) document.querySelector("#draft").dispatchEvent(new Event("changed"));
    else location.assign(`/bring/${number}`);
  } catch (error) {
    line.hidden = true;
    output.textContent = error.message;
    output.classList.add("bad");
  }
}

const areaOf = () => document.querySelector("[data-bring]");

document.addEventListener("dragover", (event) => {
  if (!areaOf() || !event.dataTransfer.types.includes("Files")) return;
  event.preventDefault();
  areaOf().classList.add("over");
});
document.addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) areaOf()?.classList.remove("over");
});
document.addEventListener("drop", async (event) => {
  const area = areaOf();
  if (!area || !event.dataTransfer.types.includes("Files")) return;
  event.preventDefault();
  area.classList.remove("over");
  bring(area, await dropped(event.dataTransfer));
});
document.addEventListener("change", (event) => {
  const area = event.target.closest("[data-bring]");
  if (area && event.target.type === "file") bring(area, chosen(event.target));
});
document.querySelector("[data-example]")?.addEventListener("click", async (event) => {
  const { unreachable } = areaOf().dataset;
  event.target.disabled = true;
  try {
    location.assign(`/bring/${(await post("/api/v1/drafts", { example: true }, unreachable)).id}`);
  } catch (error) {
    event.target.disabled = false;
    areaOf().querySelector("output").textContent = error.message;
  }
});

