"""A plant whose records lie on a PostgreSQL server: the same journal, the same head, the same answers."""

import asyncio
import contextlib
import re
import shutil

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of, command, until
from tests.integration.plant.conftest import Plant, all_collected, restored_from_an_older_copy
from tests.integration.web.bench import session_request
from truepose.storage.plant.records import Outcome
from truepose.storage.plant.tables import plant_results
from truepose.storage.record_insertion import add_row

PAGES = ("/", "/robots/120-1", "/robots/none", "/instruments/T-7")
LOOKED_UP = (
    "cells",
    "robots?limit=1",
    "robots/120-1",
    "robots/none",
    "instruments",
    "instruments/T-7",
    "campaigns",
    "models?after=1",
    "hand-downs",
    "cells/left arm/records?limit=3",
    "cells/left arm/records?kind=readings",
)
# What two plants that collected the same cannot have in common: when, and what number the cell gave.
APART = re.compile(
    r"\d{4}-\d\d-\d\dT[\d:.+]+Z?|\d\d:\d\d|\"(clock_\w+|number_in_cell)\": ?-?[\d.e-]+|[-+±]?\d+\.\d+ m?s"
)
RESULT = {"branch_id": 1, "link": 1, "robot": "IRB 120", "instrument_serial_number": "T-7"}


@pytest.fixture
def plant(on_server):
    opened = Plant(on_server())
    yield opened
    opened.database.close()


@pytest.fixture
def whole_plant(served_plant, cell):
    """Return what serves a plant on a database that has collected the cell."""

    @contextlib.asynccontextmanager
    async def served(url):
        async with served_plant(url, accounts=False) as client:
            await all_collected(client, cell)
            yield client

    return served


async def work_with(client):
    """Have results of two kinds, and hand a plan down, which is delivered."""
    results = [("campaign", 1, "120-1", "2026-05-04"), ("model", 2, "120-2", ""), ("model", 3, "120-2", "")]

    def lay(connection):
        for kind, number, serial, day in results:
            told = {"kind": kind, "record_id": number, "robot_serial_number": serial, "measured_on": day}
            add_row(connection, plant_results, name=f"Zoë's {kind}", **told, **RESULT)

    await client.here.database.write(lay)
    wanted = {"cell": "left arm", "kind": "plan", "name": "monthly", "person": "Ada", "document": {"ä": 1.5}}
    for _ in range(2):  # as somebody whose answer was lost
        answer = await client.post(
            "/api/v1/plant/hand-downs", json=wanted, headers={"Idempotency-Key": "monthly"}
        )
    async with asyncio.timeout(HANGS_S):
        while (await client.get(answer.headers["Location"])).json()["state"] != "delivered":
            await asyncio.sleep(0.02)


async def answers(client):
    """Return what a plant answers, without what two plants cannot have in common."""
    asked = [*PAGES, *(f"/api/v1/plant/{path}" for path in LOOKED_UP)]
    return {path: _comparable(await client.get(path)) for path in asked}


def _comparable(answer):
    return answer.status_code, answer.headers.get("Total-Count"), APART.sub("", answer.text)


async def test_a_plant_on_a_server_answers_what_one_on_a_file_does(
    whole_plant, cell, on_server, tmp_path, empty_database
):
    await cell.measure(3, serial="120-1", instrument="T-7")
    await cell.measure(2, name="second", serial="120-2", instrument="T-7")
    shutil.copy(empty_database, tmp_path / "plant.sqlite3")

    async with (
        whole_plant(f"sqlite:///{tmp_path}/plant.sqlite3") as on_file,
        whole_plant(on_server()) as of_server,
    ):
        plants = on_file, of_server
        for plant in plants:
            await work_with(plant)
        for plant in plants:
            await all_collected(plant, cell)
        of_file, found = [await answers(plant) for plant in plants]

    assert {status for status, _, _ in of_file.values()} == {200, 404}
    assert found == of_file


async def test_another_chain_is_accepted_on_a_server(open_cell, plant, tmp_path):
    async with restored_from_an_older_copy(open_cell, plant, tmp_path) as (cell, common, _):
        parted = await plant.visit(cell)
        await plant.journal.accept_other_chain("left arm", "Ada Byron", "the disk was exchanged")
        accepted = await plant.visit(cell)
        newest = await cell.newest()

    assert (parted.outcome, parted.fork) == (Outcome.ANOTHER_CHAIN, common)
    assert (accepted.outcome, accepted.collected) == (Outcome.WHOLE, newest - common)
    own = [link for branch, link, *_ in await plant.kept() if branch == 2]
    assert own == [*range(common + 1, newest + 1)]


async def test_a_session_of_a_cell_on_a_server_is_measured_and_collected(open_cell, plant, on_server):
    async with open_cell(url=on_server()) as cell, client_of(cell.app) as client:
        path = (await client.post("/api/v1/sessions", json=session_request(2))).headers["Location"]
        await command(client, path, "start")
        await until(client, path, lambda session: session["state"] == "awaiting_confirmation")
        await command(client, path, "confirm")
        await until(client, path, lambda session: session["state"] == "finished")
        found = await plant.visit(cell)
        head = (await cell.database.head()).text
        readings = await cell.database.read(
            lambda c: c.exec_driver_sql("SELECT count(*) FROM readings").scalar()
        )

    assert (found.outcome, found.head) == (Outcome.WHOLE, head)
    days = await plant.looks.days_of_robot("120-1")
    assert sum(day.readings for day in days) == readings > 2
