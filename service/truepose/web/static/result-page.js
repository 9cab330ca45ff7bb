// Which model judges, and against which limit, stands in the address: so it can be sent.

const form = document.querySelector("#choose");

form?.addEventListener("submit", (event) => {
  event.preventDefault();
  const address = new URLSearchParams(location.search);
  for (const { name, value } of form.querySelectorAll("[name]")) {
    if (value) address.set(name, value);
    else address.delete(name);
  }
  location.search = address.toString();
});

// On paper nothing unfolds.
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
