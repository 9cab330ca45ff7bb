// What every page has: a choice that was made is not sent on with its address, a system that wants contrast gets it,
// a menu closes where somebody taps beside it, and what cannot be undone is held.

import { holdButton } from "./hold.js";

const here = new URL(location.href);
for (const choice of ["language", "look", "units"]) here.searchParams.delete(choice);
history.replaceState(history.state, "", here);

const root = document.documentElement;
if (!root.dataset.look && matchMedia("(prefers-contrast: more)").matches) root.dataset.look = "contrast";

const menus = [...document.querySelectorAll(".menu")];
document.addEventListener("click", (event) => {
  for (const menu of menus) if (!menu.contains(event.target)) menu.open = false;
});
document.addEventListener("keydown", (event) => {
  for (const menu of menus) if (event.key === "Escape") menu.open = false;
});

// A tap alone does nothing: the button is pressed by itself once it was held.
export function holdControls(root) {
  for (const button of root.querySelectorAll("button[data-hold]")) {
    let meant = false;
    const held = () => {
      meant = true;
      button.click();
      meant = false;
    };
    button.addEventListener("click", (event) => meant || (event.preventDefault(), event.stopImmediatePropagation()));
    holdButton(button, { held, changed: () => {} });
  }
}

holdControls(document);

// Whether a finger is down on a part of the page: what is replaced then is never tapped.
export const isPressed = (part) => part.matches(":active, :has(:active)");

// What is wider than a phone is reached by keys as well, also once a tablet was turned.
export function letKeysScroll() {
  for (const wide of document.querySelectorAll(".table, .picture, pre")) {
    if (wide.scrollWidth > wide.clientWidth) wide.tabIndex = 0;
  }
}
letKeysScroll();
addEventListener("resize", letKeysScroll);
