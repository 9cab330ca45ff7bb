// Keeps the screen on where the browser allows it, and says when the tablet was opened again.

export function stayAwake(awoken) {
  const hold = () => navigator.wakeLock?.request("screen").catch(() => null);
  document.addEventListener("visibilitychange", () => {
    if (document.visibilityState !== "visible") return;
    hold();
    awoken();
  });
  window.addEventListener("pageshow", (event) => event.persisted && awoken());
  hold();
}
