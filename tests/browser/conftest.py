"""A service on fake devices behind a real socket, and a Chromium of the system that looks at it."""

import contextlib
import functools
import shutil
import time

import httpx
import pytest
from playwright.sync_api import expect

from tests.browser.shared_playwright import SharedPlaywright
from tests.browser.windows import Windows, without_complaint
from tests.helpers.domain.builders import make_identification
from tests.helpers.machine import CHROMIUM
from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.listening import listening
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.analysis.job_queue.tasks import DrawTask, IdentifyTask
from truepose.app import create_app
from truepose.settings import Settings

# The bare shell of the browser paints the same pages for a third of the work.
_NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
_PATIENCE_S = 60.0  # on a busy machine
expect.set_options(timeout=1000.0 * _PATIENCE_S)  # of 5 s by itself, which a page on a busy machine may take


class Diagnostician:
    """Answers with what it was told to give and identifies nothing; promises it works out, and draws."""

    def __init__(self):
        self.answer = None

    async def __call__(self, task, told):
        if isinstance(task, IdentifyTask):
            return make_identification(model=None)
        return task.perform(lambda *_: None) if isinstance(task, PromiseTask | DrawTask) else self.answer


class Service:
    """What tests ask of the running service beside looking at its pages."""

    def __init__(self, client, worker):
        self.url = str(client.base_url).rstrip("/")
        self._worker = worker
        self._client = client

    def get(self, path):
        return self._client.get(path).json()

    def post(self, path, body=None):
        reply = self._client.post(path, json=body)
        assert reply.is_success, reply.text
        return reply

    def until(self, path, key, *values):
        end = time.monotonic() + _PATIENCE_S
        while (found := self.get(path))[key] not in values:
            assert time.monotonic() < end, found
            time.sleep(0.02)
        return found

    def plan_with(self, plan):
        """Let the worker answer whoever plans a session with this plan."""
        self._worker.answer = plan

    def measured_session(self, name, n=3):
        """Measure a whole session and return its path."""
        path = self._started(name, n)
        self.until(path, "state", "finished")
        return path

    def paused_session(self, name):
        """Return a session that a person has paused after its first readings."""
        path = self._started(name, n=60)
        while self.get(path)["measured"] < 2:
            time.sleep(0.005)
        self.command(path, "pause")
        assert self.until(path, "state", "paused", "finished")["state"] == "paused"
        return path

    def _started(self, name, n):
        for device in ("tracker", "robot"):
            self.post(f"/api/v1/devices/{device}/connect")
        path = self.post("/api/v1/sessions", session_request(n, name=name)).headers["Location"]
        self.command(path, "start")
        self.until(path, "state", "awaiting_confirmation")
        self.command(path, "confirm")
        return path

    def command(self, path, name):
        """Ask something of a session as Ada Byron would, who reads what it asks."""
        asked = (self.get(f"{path}/situation")["prompt"] or {}).get("id")
        self.post(f"{path}/commands", {"command": name, "person": "Ada Byron", "prompt_id": asked})

    def diagnosed(self, session, answer):
        """Diagnose a session and return the address of the page, drawn to its end."""
        self._worker.answer = answer
        job = self.post(f"{session}/diagnosis", {}).headers["Location"]
        page = self.until(job, "state", "succeeded")["result_url"].removeprefix("/api/v1")
        return f"{self.url}{page}?whole=true"


def settings_in(folder, empty_database):
    """The settings of a service whose cell and database, still without records, lie in a folder."""
    (folder / "cell.toml").write_text(CELL)
    database = shutil.copy(empty_database, folder)
    return Settings(database_url=f"sqlite:///{database}", cell_file=folder / "cell.toml")


@pytest.fixture
def service(tmp_path, empty_database):
    where = settings_in(tmp_path, empty_database)
    worker = Diagnostician()
    application = create_app(where, Bench().registry(), worker)
    with listening(application) as url, httpx.Client(base_url=url, timeout=_PATIENCE_S) as client:
        yield Service(client, worker)


@pytest.fixture(scope="session")
def shared_chromium():
    """One browser for all files of a process: to start one takes longer than most files look at it."""
    path = next(filter(None, map(shutil.which, _NAMES)), None)
    if path is None:
        pytest.skip(CHROMIUM.reason)
    with SharedPlaywright() as shared:
        # The sandbox needs rights that a container's root user does not have; the pages are our own.
        arguments = ["--no-sandbox", "--host-resolver-rules=MAP evil.test 127.0.0.1"]
        with shared.in_use() as playwright:
            start = functools.partial(playwright.chromium.launch, executable_path=path, args=arguments)
            windows = Windows(start)
        yield shared, windows
        with shared.in_use():
            windows.close()


@pytest.fixture(scope="module")
def chromium(shared_chromium):
    shared, windows = shared_chromium
    with shared.in_use():
        yield windows


@contextlib.contextmanager
def looking(chromium, origin):
    """Open a page of a tablet's size; whatever it complains of or fetches from elsewhere fails the test."""
    with chromium.one(origin) as page, without_complaint(page, origin):
        yield page


@pytest.fixture
def tablet(chromium, service):
    with looking(chromium, service.url) as page:
        yield page


@pytest.fixture
def reader(chromium, tmp_path):
    """A page that opens reports as files, as whoever gets one by mail does."""
    with looking(chromium, tmp_path.as_uri()) as page:
        yield page
