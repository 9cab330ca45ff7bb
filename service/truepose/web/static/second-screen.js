// A second screen: a link to this session for looking at only, as a QR code that a telephone reads.

import { post } from "./api.js";

const place = document.querySelector("#second-screen");
const dialog = place?.querySelector("dialog");
place?.querySelector(".leave").addEventListener("click", () => dialog.close());

place?.querySelector("button:not(.leave)").addEventListener("click", async () => {
  const said = place.querySelector("output");
  said.textContent = "";
  try {
    const made = await post(place.dataset.path, { hours: 12 }, place.dataset.unreachable);
    dialog.querySelector("img").src = made.qr_svg;
    const link = Object.assign(document.createElement("a"), { href: made.url, textContent: made.url, target: "_blank", rel: "noreferrer" });
    dialog.querySelector(".link").replaceChildren(link);
    dialog.showModal();
  } catch (error) {
    said.textContent = error.message;
  }
});
