"""The whole service over ASGI, on fake devices and a real database."""

import asyncio
import shutil

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of
from tests.helpers.web.performing import perform_here
from tests.integration.web.bench import CELL, Bench
from truepose.analysis.job_queue.uploads import Uploads
from truepose.app import create_app
from truepose.settings import Settings


@pytest.fixture
def database_url(empty_database, tmp_path):
    """A copy of the empty database: to make its schema anew takes longer than most requests."""
    return f"sqlite:///{shutil.copy(empty_database, tmp_path)}"


@pytest.fixture(autouse=True)
def hardly_drawn(empty_pictures):
    """What pictures show is tested in `tests/unit/service/reports` and `tests/browser`."""


@pytest.fixture(autouse=True, scope="module")
def in_forked_processes(forked_processes):
    """That workers load by themselves what they need is tested in `tests/integration/analysis`."""


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def cell_text():
    """The cell file; modules about other cells say which."""
    return CELL


@pytest.fixture
def settings(tmp_path, database_url, cell_text):
    cell_file = tmp_path / "cell.toml"
    cell_file.write_text(cell_text)
    return Settings(database_url=database_url, cell_file=cell_file)


@pytest.fixture
def worker():
    """Who does the jobs and draws pages: this process; tests of `tests/system` have processes."""
    return perform_here


@pytest.fixture
def uploads():
    """Who reads what is uploaded: this process; `test_campaigns.py` has a worker's, as a service."""
    return Uploads(perform_here)


@pytest.fixture
async def app(settings, bench, worker, uploads):
    application = create_app(settings, bench.registry(), worker)
    async with application.router.lifespan_context(application):
        application.state.context.campaign_desk.uploads = uploads
        yield application


@pytest.fixture
async def client(app):
    async with client_of(app) as opened:
        yield opened


@pytest.fixture
def until(client):
    return asking(client)


def asking(client):
    """Return what asks a resource until a key has one of the values given; fails after a minute.

    A worker that begins takes a second on an idle machine, and many on a busy one.
    """

    async def ask(path, key, *values):
        async with asyncio.timeout(HANGS_S):
            while (found := (await client.get(path)).json()).get(key) not in values:
                await asyncio.sleep(0.005)
        return found

    return ask
