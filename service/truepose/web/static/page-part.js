// The page as it is by now, in place of what it was: the server writes it, and what had the focus keeps it.

export async function inPage(selector, unreachable) {
  const reply = await fetch(location.href).catch(() => null);
  if (!reply?.ok) throw new Error(unreachable);
  const fresh = new DOMParser().parseFromString(await reply.text(), "text/html").querySelector(selector);
  const focus = addressOf(document.activeElement);
  document.querySelector(selector).replaceWith(fresh);
  if (focus) document.querySelector(focus)?.focus({ preventScroll: true });
}

function addressOf(element) {
  if (!element || element === document.body) return "";
  const file = element.closest("[data-file]");
  const own = ["column", "unit", "text"].find((name) => name in element.dataset);
  const within = file ? `[data-file="${CSS.escape(file.dataset.file)}"] ` : "";
  return own ? `${within}[data-${own}="${CSS.escape(element.dataset[own])}"]` : "";
}
