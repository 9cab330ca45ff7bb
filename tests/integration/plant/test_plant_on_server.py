"""A plant whose records lie on a PostgreSQL server: the same journal, the same head, the same answers."""

import os

import pytest

from tests.helpers.machine import POSTGRESQL
from tests.helpers.postgresql.server import programs, shared_server
from tests.integration.plant.conftest import Plant
from truepose.storage.plant.records import Outcome
from truepose.storage.records import Page


@pytest.fixture
def plant(tmp_path, monkeypatch):
    if programs() is None:
        pytest.skip(POSTGRESQL.reason)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "beside"))
    with shared_server() as server:
        name = f"plant_{os.getpid()}"
        opened = Plant(server.make(name))
        try:
            yield opened
        finally:
            opened.database.close()
            server.drop(name)


async def test_a_cell_is_collected_onto_a_server(plant, cell):
    await cell.measure(3, serial="120-1", instrument="T-7")
    first = await plant.visit(cell)
    await cell.measure(2, name="second", serial="120-2", instrument="T-7")
    found = await plant.visit(cell)

    newest = await cell.newest()
    assert (first.outcome, found.outcome) == (Outcome.WHOLE, Outcome.WHOLE)
    assert [link for _, link, *_ in await plant.kept()] == [*range(1, newest + 1)]
    assert found.head == (await cell.database.head()).text
    robots = await plant.looks.robots(Page())
    assert [robot.serial_number for robot in robots] == ["120-1", "120-2"]
    days = await plant.looks.days_of_instrument("T-7")
    assert sum(day.readings for day in days) == 5
    assert (await plant.visits.newest())["left arm"].visit.head == found.head
