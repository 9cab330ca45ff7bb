"""What is measured on a page: what axe finds, how large controls are, what it weighs, whether it fits."""

import time

from axe_playwright_python.base import AXE_SCRIPT

# The three looks of all pages; a page that follows the system is light or dark.
_PATIENCE_S = 60.0  # on a busy machine
LOOKS = ("light", "dark", "contrast")
# Everything that axe calls a violation, but contrast. That is to be 7:1 in a hall, in each look: one rule of
# axe finds what lies between 4.5 and 7, another what lies below. Both take long: they look at the first three
# texts of each kind, of one colour and in elements of the same names, classes and backgrounds.
_AXE = """() => axe.run({
  resultTypes: ["violations"],
  rules: { "color-contrast": { enabled: false } },
}).then(({ violations }) => violations)"""
_CONTRAST = """() => {
  const around = (node) => node === null ? "" : [around(node.parentElement), node.tagName, node.className,
    getComputedStyle(node).backgroundColor].join(" ");
  const written = (node) => node.checkVisibility() && (node.matches("input, select, textarea")
    || [...node.childNodes].some((part) => part.nodeType === Node.TEXT_NODE && part.data.trim() !== ""));
  const texts = [...document.querySelectorAll("body *")].filter(written);
  const kinds = Map.groupBy(texts, (node) => `${around(node)} ${getComputedStyle(node).color}`);
  const few = [...kinds.values()].flatMap((nodes) => nodes.slice(0, 3));
  return axe.run(few, {
    resultTypes: ["violations"],
    runOnly: ["color-contrast", "color-contrast-enhanced"],
  }).then(({ violations }) => violations); }"""
# Of what is written in a picture axe cannot tell the contrast; it takes its time all the same.
_WITHOUT_PICTURES = '() => document.querySelectorAll("svg").forEach((picture) => picture.replaceChildren())'
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


def violations(page):
    """Return what axe finds: everything that has one look, and the contrast of each."""
    page.evaluate(_SHORTENED)
    page.evaluate(AXE_SCRIPT)
    found = _told(page.evaluate(_AXE))
    page.evaluate(_WITHOUT_PICTURES)
    for look in LOOKS:
        page.evaluate("(look) => { document.documentElement.dataset.look = look; }", look)
        found += [f"{look}: {told}" for told in _told(page.evaluate(_CONTRAST))]
    return found


def _told(violations):
    return [
        f"{one['id']}: {node['html'][:120]} {node['target']}" for one in violations for node in one["nodes"]
    ]


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
