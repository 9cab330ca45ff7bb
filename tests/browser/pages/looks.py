"""What is measured on a page: what axe finds, how large controls are, what it weighs, whether it fits."""

import time

from axe_playwright_python.base import AXE_SCRIPT

# The three looks of all pages; a page that follows the system is light or dark.
_PATIENCE_S = 60.0  # on a busy machine
LOOKS = ("light", "dark", "contrast")
# Everything that axe calls a violation, and the contrast of 7:1 that a hall asks for.
_AXE = """(rules) => axe.run({
  resultTypes: ["violations"],
  ...(rules.length ? { runOnly: rules } : {}),
  rules: { "color-contrast-enhanced": { enabled: true } },
}).then(({ violations }) => violations.flatMap(
  ({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 120)} (${node.target.join(" ")})`)))"""
_CONTRAST = ["color-contrast-enhanced"]
# Controls that a finger in a glove may miss: the main ones are to be 72 px high, all others 48 px. A link in
# a sentence is as high as its line, and a box that is ticked is pressed on its label.
_TOO_SMALL = """() => [...document.querySelectorAll("button, .button, select, textarea, input, summary")]
  .filter((node) => node.checkVisibility() && !node.disabled)
  .filter((node) => !node.matches("[type=hidden], [type=checkbox], [type=radio], [type=file]"))
  .filter((node) => node.offsetHeight < (node.matches(".main, .act-main") ? 72 : 48))
  .map((node) => `${node.outerHTML.slice(0, 90)} is ${node.offsetHeight} px high`)"""
# What scrolls by itself may hold something wider.
_WIDER = """() => {
  const { scrollWidth, clientWidth } = document.documentElement;
  const wider = [...document.querySelectorAll("body *")]
    .filter((node) => node.getBoundingClientRect().right > clientWidth + 1)
    .filter((node) => !node.parentElement.closest(".table, .picture, pre"));
  return scrollWidth <= clientWidth ? []
    : [`${scrollWidth - clientWidth} px`, ...wider.map((node) => node.outerHTML.slice(0, 90))]; }"""


# Of a long row of the like, the first are looked at: the description of the API has four hundred tables.
_SHORTENED = """() => {
  const seen = (node) => node.children.length > 24;
  [...document.querySelectorAll("body *")].filter(seen)
    .forEach((node) => [...node.children].slice(24).forEach((child) => child.remove())); }"""


def violations(page, look):
    """Return what axe finds: everything in the first look, and contrast in the others."""
    page.evaluate("(look) => { document.documentElement.dataset.look = look; }", look)
    if not page.evaluate("'axe' in window"):
        page.evaluate(_SHORTENED)
        page.evaluate(AXE_SCRIPT)
    return page.evaluate(_AXE, [] if look == LOOKS[0] else _CONTRAST)


def too_small(page):
    """Return the controls that are too low to be hit."""
    return page.evaluate(_TOO_SMALL)


def sticking_out(page):
    """Return what makes the page scroll sideways."""
    return page.evaluate(_WIDER)


class Traffic:
    """What a page has fetched so far, and whether it waits for more; streams never end."""

    def __init__(self, page):
        self.weight = 0  # bytes of the answers as they were sent, heads included
        self._sizes, self._streams, self._waiting = {}, set(), set()
        heard = page.context.new_cdp_session(page)
        heard.send("Network.enable")
        heard.send("Network.setCacheDisabled", {"cacheDisabled": True})
        heard.on("Network.requestWillBeSent", self._asked)
        heard.on("Network.responseReceived", self._answered)
        heard.on("Network.loadingFinished", self._finished)
        heard.on("Network.loadingFailed", lambda told: self._waiting.discard(told["requestId"]))
        self._page, self._heard = page, heard

    def _asked(self, told):
        if told["type"] == "Document":  # nobody waits any more for what the page before had asked for
            self._waiting.clear()
        self._waiting.add(told["requestId"])

    def _answered(self, told):
        if told["response"]["mimeType"] == "text/event-stream":
            self._waiting.discard(told["requestId"])

    def _finished(self, told):
        self.weight += int(told["encodedDataLength"])
        self._waiting.discard(told["requestId"])

    def settled(self):
        """Return once nothing is on its way any more."""
        end = time.monotonic() + _PATIENCE_S
        while self._waiting:
            assert time.monotonic() < end, "the page does not stop asking"
            self._page.wait_for_timeout(20)

    def close(self):
        self._heard.detach()
