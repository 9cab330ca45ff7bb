"""A fake desk behind a real socket, and tablets that look at it."""

import contextlib
import socket

import pytest

from tests.browser.tablet.bench.fake_desk import FakeDesk
from tests.browser.tablet.bench.kept_files import KeptFiles
from tests.browser.tablet.bench.wire import wire_to
from tests.browser.windows import PORTRAIT, without_complaint
from tests.integration.web.listening import listening
from truepose.web.middleware.hosts import AllowedHosts, Proxies
from truepose.web.middleware.security import SecurityMiddleware

_UNREACHED = "Failed to load resource"  # Chromium's own word where nobody answers


@pytest.fixture(scope="session")
def door():
    """One port for the desks of many tests: a browser keeps the files that it has from there."""
    with socket.create_server(("127.0.0.1", 0)) as door:
        yield door


@pytest.fixture
def desk():
    return FakeDesk()


def served(desk, door):
    """Serve a desk as the service does, within a context that gives its URL."""
    return listening(KeptFiles(SecurityMiddleware(desk.application(), AllowedHosts(), Proxies())), door)


@pytest.fixture
def url(desk, door):
    with served(desk, door) as url:
        yield url


@contextlib.contextmanager
def a_tablet(chromium, url, *, size=PORTRAIT, may_fail=False, scripts=(), **told):
    """Open a tablet that keeps nothing of another one, but what it is told: `language`, `person`, `tablet`.

    Complaints of the page fail the test.
    """
    kept = {"language": "en", "person": "Ada Byron", **told}
    storing = [_storing(f"truepose.{name}", value) for name, value in kept.items() if value]
    window = chromium.one(url, size, touch=True, scripts=[*storing, *scripts])
    with window as page, without_complaint(page, url, [_UNREACHED] if may_fail else []):
        yield page


def _storing(name, value):
    return f"localStorage.getItem('{name}') ?? localStorage.setItem('{name}', '{value}')"


@pytest.fixture
def tablet(chromium, desk, url):
    with a_tablet(chromium, url) as page:
        page.goto(f"{url}/operator/3")
        yield page


@pytest.fixture
def wired(chromium, desk, url):
    """A tablet behind a wire that a test can cut."""
    with wire_to(url) as (wire, near), a_tablet(chromium, near, may_fail=True) as page:
        page.goto(f"{near}/operator/3")
        page.locator("#link[data-state=up]").wait_for()
        yield page, wire
