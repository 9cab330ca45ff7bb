// A button that must be held: gloves and a wet screen make single taps, not a second and a half.

const HOLD_MS = 1500;
const KEYS = [" ", "Enter"];

export function holdButton(button, { held, changed }) {
  let timer = null;
  const release = () => {
    clearTimeout(timer);
    if (timer !== null) changed(false);
    timer = null;
    button.classList.remove("holding");
  };
  const press = () => {
    if (timer !== null || button.disabled) return;
    button.classList.add("holding");
    changed(true);
    timer = setTimeout(() => {
      // Nobody holds a screen that went dark, or a button that is gone.
      const meant = !button.disabled && button.isConnected && !document.hidden;
      release();
      if (meant) held();
    }, HOLD_MS);
  };
  button.style.setProperty("--hold", `${HOLD_MS}ms`);
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    press();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur"])
    button.addEventListener(name, release);
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  button.addEventListener("keydown", (event) => {
    if (!KEYS.includes(event.key)) return;
    event.preventDefault();
    if (!event.repeat) press();
  });
  button.addEventListener("keyup", (event) => KEYS.includes(event.key) && release());
}
