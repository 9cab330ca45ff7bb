"""A cell with records on a real database, and a plant beside it that reaches it without a network."""

import asyncio
import contextlib
import dataclasses
import itertools
import os
import shutil
from datetime import UTC, datetime

import httpx
import pytest

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of
from tests.integration.web.bench import CELL, Bench
from truepose.app import create_app
from truepose.app.plants import open_plant as opened_plant
from truepose.domain.cell import DeviceEntry
from truepose.exchange.cells.plant import PlantCell
from truepose.plant import collector
from truepose.plant.cell_client import CellClient
from truepose.plant.collector import PlantRepositories, visit
from truepose.settings import PlantSettings, Settings
from truepose.storage.database import Database
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.plant.cells import VisitRepository
from truepose.storage.plant.deployments import HandDownRepository
from truepose.storage.plant.journal import JournalRepository
from truepose.storage.plant.queries import PlantQueries
from truepose.web.plant.application import create_plant_application

_NUMBERS = itertools.count()


@pytest.fixture
def on_server(server, tmp_path, monkeypatch):
    """Return what makes a database of its own on a server and returns its address."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "beside"))
    made = []

    def address():
        made.append(f"plant_{os.getpid()}_{next(_NUMBERS)}")
        return server.make(made[-1])

    yield address
    for name in made:
        server.drop(name)


class Cell:
    """A cell's service in this process."""

    def __init__(self, app):
        self.app = app
        self.transport = httpx.ASGITransport(app)

    @property
    def database(self):
        return self.app.state.context.database

    async def measure(
        self, readings=3, name="first", serial="120-1", instrument="T-7", certificate="", expires=""
    ):
        """Measure a session; returns its number."""
        tracker = DeviceEntry("tracker", "fake_tracker", {}, instrument, certificate, expires)
        setup = make_setup()
        told = dataclasses.replace(setup.cell, robot_serial_number=serial, devices=(tracker,))
        stored = SessionRepository(self.database)
        number = await stored.add(name, dataclasses.replace(setup, cell=told), make_plan())
        ledger = LedgerRepository(self.database)
        for nest in range(1, readings + 1):
            await ledger.append(number, point_taken(make_point(1, nest=nest)))
        return number

    async def newest(self):
        return (await self.database.head()).links


class Plant:
    """The storage of a plant, and visits to cells."""

    def __init__(self, url):
        self.database = Database(url)
        self.journal = JournalRepository(self.database)
        self.hand_downs = HandDownRepository(self.database)
        self.visits = VisitRepository(self.database)
        self.looks = PlantQueries(self.database)

    async def visit(self, cell, name="left arm", transport=None, wall_time=None):
        asked = CellClient(PlantCell(name, "http://localhost"), wall_time, transport or cell.transport)
        await self.journal.enter(name)
        try:
            found = await visit(name, asked, PlantRepositories(self.journal, self.hand_downs))
        finally:
            await asked.close()
        await self.visits.keep(name, found)
        return found

    async def kept(self):
        """Return cell, link, record and number of every line of the journal, in the order of keeping."""
        query = "SELECT branch_id, link, record, record_id FROM plant_journal ORDER BY id"
        return await self.database.read(lambda c: [tuple(row) for row in c.exec_driver_sql(query)])

    async def position(self, name="left arm"):
        return (await self.journal.reached(name)).position


@pytest.fixture
def open_cell(tmp_path, empty_database):
    """Return what opens a cell on a file of a name, or on a server's database."""

    @contextlib.asynccontextmanager
    async def opened(name="cell", url=None):
        folder = tmp_path / name
        file = folder / "truepose.sqlite3"
        if not folder.exists():
            folder.mkdir()
            shutil.copy(empty_database, file)
            (folder / "cell.toml").write_text(CELL)
        settings = Settings(database_url=url or f"sqlite:///{file}", cell_file=folder / "cell.toml")
        app = create_app(settings, Bench().registry())
        async with app.router.lifespan_context(app):
            yield Cell(app)

    return opened


@pytest.fixture
async def cell(open_cell):
    async with open_cell() as opened:
        yield opened


@pytest.fixture
def open_plant(tmp_path, empty_database):
    """Return what opens a plant's database of a name."""

    @contextlib.contextmanager
    def opened(name="plant"):
        file = tmp_path / f"{name}.sqlite3"
        if not file.exists():
            shutil.copy(empty_database, file)
        plant = Plant(f"sqlite:///{file}")
        try:
            yield plant
        finally:
            plant.database.close()

    return opened


@pytest.fixture
def plant(open_plant):
    with open_plant() as opened:
        yield opened


@pytest.fixture
def noon():
    return datetime(2026, 5, 4, 12, tzinfo=UTC)


@pytest.fixture
def cells_file(tmp_path):
    """A file that names the cell."""
    file = tmp_path / "cells.toml"
    file.write_text('[[cell]]\nname = "left arm"\nurl = "http://localhost"\n')
    return file


@pytest.fixture
def served_plant(cells_file, cell, monkeypatch):
    """Return what serves a plant on a database, which reaches the cell without a network."""
    monkeypatch.setattr(collector, "CellClient", lambda of: CellClient(of, transport=cell.transport))

    @contextlib.asynccontextmanager
    async def served(url, every_s=3600.0, workers=None, **differing):
        service = Settings(database_url=url, **differing)
        settings = PlantSettings(service, cells_file, every_s=every_s, workers=workers)
        app = create_plant_application("test", lambda: opened_plant(settings))
        async with app.router.lifespan_context(app), client_of(app) as client:
            client.here = app.state.context
            yield client

    return served


async def all_collected(client, cell):
    """Wait until all that the cell has is there: a visit may fall between two records of a measurement."""
    newest = await cell.newest()
    client.here.collector.visit_soon("left arm")
    async with asyncio.timeout(HANGS_S):
        while (await client.here.journal.reached("left arm")).position < newest:
            await asyncio.sleep(0.02)


@contextlib.asynccontextmanager
async def restored_from_an_older_copy(open_cell, plant, tmp_path):
    """Yield a cell that measured on since its copy was put back, and its links in the copy and in the plant.

    What it measured between the copy and the loss of its disk is in the plant alone.
    """
    async with open_cell() as cell:
        await cell.measure()
        common = await cell.newest()
    shutil.copytree(tmp_path / "cell", tmp_path / "copy")
    async with open_cell() as cell:
        await cell.measure(name="lost with the disk")
        await plant.visit(cell)
        collected = await cell.newest()
    async with open_cell("copy") as cell:
        await cell.measure(6, name="measured since")
        yield cell, common, collected
