// No module, so that it is there before anything can be pressed: what is pressed or sent while its page's scripts are
// still on their way is pressed or sent once they are all there.

let late = null;
const keepBack = (event) => {
  event.preventDefault();
  event.stopImmediatePropagation(); // a script that is there already would act on it as well
};
const listeners = {
  submit(event) {
    keepBack(event);
    late = () => event.target.requestSubmit(event.submitter);
  },
  click(event) {
    const button = event.target.closest("button");
    if (!button || button.form) return; // a form's button sends it
    keepBack(event);
    late = () => button.click();
  },
};
for (const [kind, listener] of Object.entries(listeners)) document.addEventListener(kind, listener, true);
document.addEventListener("DOMContentLoaded", () => {
  for (const [kind, listener] of Object.entries(listeners)) document.removeEventListener(kind, listener, true);
  late?.();
});
