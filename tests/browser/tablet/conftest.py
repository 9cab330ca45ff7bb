"""A fake desk behind a real socket, and tablets that look at it."""

import contextlib

import pytest

from tests.browser.tablet.fake_desk import FakeDesk
from tests.browser.tablet.wire import wire_to
from tests.integration.web.listening import listening
from truepose.web.door.hosts import AllowedHosts
from truepose.web.door.middleware import Door

PORTRAIT = {"width": 800, "height": 1280}
LANDSCAPE = {"width": 1280, "height": 800}
_UNREACHED = "Failed to load resource"  # Chromium's own word where nobody answers


@pytest.fixture
def desk():
    return FakeDesk()


def served(desk):
    """Serve a desk as the service does, within a context that gives its URL."""
    return listening(Door(desk.application(), AllowedHosts()))


@pytest.fixture
def url(desk):
    with served(desk) as url:
        yield url


@contextlib.contextmanager
def a_tablet(chromium, url, *, size=None, person="Ada Byron", language="en", may_fail=False, number=None):
    """Open a tablet that keeps nothing of another one, unless it is given its number.

    Complaints of the page fail the test.
    """
    context = chromium.new_context(viewport=size or PORTRAIT, base_url=url, has_touch=True)
    kept = {"language": language, "person": person, "tablet": number}
    for name, value in ((f"truepose.{name}", value) for name, value in kept.items() if value):
        context.add_init_script(
            f"localStorage.getItem('{name}') ?? localStorage.setItem('{name}', '{value}')"
        )
    page = context.new_page()
    complaints = []
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda r: None if r.url.startswith((url, "data:")) else complaints.append(r.url))
    yield page
    context.close()
    assert [text for text in complaints if not (may_fail and text.startswith(_UNREACHED))] == []


@pytest.fixture
def tablet(chromium, desk, url):
    with a_tablet(chromium, url) as page:
        page.goto("/operator/3")
        yield page


@pytest.fixture
def wired(chromium, desk, url):
    """A tablet behind a wire that a test can cut."""
    with wire_to(url) as (wire, near), a_tablet(chromium, near, may_fail=True) as page:
        page.goto("/operator/3")
        page.locator("#link[data-state=up]").wait_for()
        yield page, wire
