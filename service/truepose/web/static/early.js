// No module, so that it is there before anything can be pressed: a form that is sent while its page's scripts are
// still on their way is sent when they are there.

let sent = null;
const keep = (event) => {
  event.preventDefault();
  sent = event;
};
document.addEventListener("submit", keep);
document.addEventListener("DOMContentLoaded", () => {
  document.removeEventListener("submit", keep);
  sent?.target.requestSubmit(sent.submitter);
});
