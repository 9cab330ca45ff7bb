"""Windows of one Chromium, used again: to open one takes longer than most tests look at it."""

import contextlib

PORTRAIT = {"width": 800, "height": 1280}
LANDSCAPE = {"width": 1280, "height": 800}


class Windows:
    """The windows of a browser, which `launch` starts; each is as new whenever it is handed out."""

    def __init__(self, launch):
        self._launch = launch
        self._open_anew()

    def _open_anew(self):
        self._browser = self._launch()
        self._free = {True: [], False: []}  # with and without touch

    @contextlib.contextmanager
    def one(self, origin, size=PORTRAIT, *, touch=False, scripts=()):
        """Yield a page that has stored nothing for `origin` and runs the scripts before its own."""
        if not self._browser.is_connected():  # it crashed in an earlier test, which has failed
            self._open_anew()
        free = self._free[touch]
        window = free.pop() if free else _Window(self._browser, touch)
        try:
            window.prepared(size, scripts)
            yield window.page
            window.cleared(origin)
        except BaseException:
            window.close()  # nobody knows what a failed test leaves behind
            raise
        free.append(window)

    def close(self):
        self._browser.close()


_PATIENCE_MS = 120_000  # for a page or a control, on a machine that does four other things


class _Window:
    def __init__(self, browser, touch):
        self._context = browser.new_context(has_touch=touch)
        self._context.set_default_timeout(_PATIENCE_MS)
        self.page = self._context.new_page()
        # A script that Playwright adds stays; one that is added below it can be taken away again.
        self._browser = self._context.new_cdp_session(self.page)
        self._browser.send("Page.enable")
        self._scripts = []

    def prepared(self, size, scripts):
        self.page.set_viewport_size(size)
        self._scripts = [
            self._browser.send("Page.addScriptToEvaluateOnNewDocument", {"source": script})
            for script in scripts
        ]

    def cleared(self, origin):
        page = self.page
        page.goto("about:blank")
        page.mouse.move(0, 0)
        page.emulate_media(media="null")
        page.unroute_all(behavior="wait")
        self._context.unroute_all(behavior="wait")
        self._context.set_offline(False)
        self._context.clear_cookies()
        for script in self._scripts:
            self._browser.send("Page.removeScriptToEvaluateOnNewDocument", script)
        self._browser.send("Storage.clearDataForOrigin", {"origin": origin, "storageTypes": "all"})

    def close(self):
        self._context.close()


@contextlib.contextmanager
def without_complaint(page, origin, allowed=()):
    """Fail whatever the page complains of or fetches from elsewhere, but what begins as is `allowed`."""
    complaints = []
    heard = {
        "console": lambda message: complaints.append(_said(message)) if _complains(message) else None,
        "pageerror": lambda error: complaints.append(str(error)),
        "request": lambda r: None if r.url.startswith((origin, "data:")) else complaints.append(r.url),
    }
    for event, hear in heard.items():
        page.on(event, hear)
    yield
    page.evaluate("0")  # whatever it has said by now is heard before the answer
    for event, hear in heard.items():
        page.remove_listener(event, hear)
    unexpected = [text for text in complaints if not text.startswith(tuple(allowed))]
    assert not unexpected, unexpected


def _complains(message):
    """Say whether it is an error, or of a rule for pages that is broken, which need not be one."""
    return message.type == "error" or "Policy" in message.text


def _said(message):
    """Return what the console says, and what it is of."""
    return f"{message.text} {message.location['url']}"
