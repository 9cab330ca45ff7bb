// Hands the address of a page on: by the system's own sheet where it has one, else into the clipboard, else by mail.

async function share(said) {
  const page = { title: document.title, url: location.href };
  if (navigator.share) return navigator.share(page).catch(() => {}); // who closes the sheet has changed their mind
  try {
    await navigator.clipboard.writeText(page.url); // only of a page that came by TLS, or from this computer
    said.textContent = said.dataset.shared;
  } catch {
    location.assign(`mailto:?subject=${encodeURIComponent(page.title)}&body=${encodeURIComponent(page.url)}`);
  }
  return undefined;
}

for (const button of document.querySelectorAll("[data-share]")) {
  button.hidden = false;
  button.addEventListener("click", () => share(button.parentElement.querySelector("[data-shared]")));
}
