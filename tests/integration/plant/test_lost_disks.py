"""A disk is lost, the plant's or a cell's: what a copy brings back, what is collected again, what is left."""

import asyncio
import json
import os

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of
from tests.integration.plant.conftest import Plant
from truepose.app.plants import open_plant as served_by
from truepose.plant import collector as visiting
from truepose.settings import PlantSettings, Settings
from truepose.storage.backup import schedule
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.backup.schedule import back_up_at, restore_at
from truepose.storage.integrity.verification import verify_left, verify_left_at
from truepose.storage.plant import journal
from truepose.storage.plant.deployments import HandedDownRepository
from truepose.storage.plant.journal import JournalLines
from truepose.storage.plant.records import HandDown, HandDownKind, Outcome
from truepose.storage.records import Page
from truepose.web.plant.application import create_plant_application


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request, tmp_path):
    """Return what names an empty database of an engine."""
    if request.param == "postgresql":
        return request.getfixturevalue("on_server")
    return lambda: f"sqlite:///{tmp_path}/{os.urandom(4).hex()}.sqlite3"


@pytest.fixture
def opened():
    """Return what opens a plant on a database, and closes the one before."""
    plants = []

    def opened(url):
        for plant in plants:
            plant.database.close()
        plants[:] = [Plant(url)]
        return plants[0]

    yield opened
    for plant in plants:
        plant.database.close()


def plan(name):
    return HandDown("left arm", HandDownKind.PLAN, name, "Ada Byron", {"name": name})


async def test_a_plant_put_back_collects_what_is_missing_once(address, opened, cell, tmp_path):
    copy, again = tmp_path / "copy.sqlite3", address()
    plant = opened(first := address())
    await cell.measure()
    await plant.visit(cell)
    await plant.hand_downs.add(plan("before"))
    made = back_up_at(first, copy)
    await cell.measure(name="second")
    await plant.visit(cell)
    of_first = [link for _, link, *_ in await plant.kept()]

    restore_at(copy, again)
    plant = opened(again)
    behind = await plant.position()
    await cell.measure(name="third")
    found = await plant.visit(cell)

    newest = await cell.newest()
    assert made.head == verify_left(copy).head
    assert behind < len(of_first) < newest
    assert (found.outcome, found.collected) == (Outcome.WHOLE, newest - behind)
    assert [link for _, link, *_ in await plant.kept()] == [*range(1, newest + 1)]
    assert sum(day.readings for day in await plant.looks.days_of_robot("120-1")) == 9
    names = [record.handed_down.name for record in await HandedDownRepository(cell.database).page(Page())]
    assert names == ["before"]  # it was waiting in the copy, and was delivered before and after
    assert verify_left_at(again).findings == ()


async def test_a_plant_makes_copies_while_it_serves_and_says_how_old_the_newest_is(
    open_plant, tmp_path, monkeypatch
):
    monkeypatch.setattr(schedule, "_FIRST_S", 0.0)
    with open_plant():
        pass
    (tmp_path / "cells.toml").write_text('[[cell]]\nname = "left arm"\nurl = "http://localhost"\n')
    wanted = BackupPlan(tmp_path / "copies")
    settings = Settings(database_url=f"sqlite:///{tmp_path}/plant.sqlite3", backups=wanted)
    app = create_plant_application(
        "test", lambda: served_by(PlantSettings(settings, tmp_path / "cells.toml"))
    )

    async with app.router.lifespan_context(app), client_of(app) as client:
        async with asyncio.timeout(HANGS_S):
            while (health := (await client.get("/health")).json())["newest_copy_age_s"] is None:
                await asyncio.sleep(0.01)
        wanted.folder.rename(tmp_path / "away")
        wanted.folder.write_text("a file where the folder of copies was")
        await app.state.context.copies.make_if_due()
        amiss = (await client.get("/health")).json()

    assert health["status"] == "ok"
    assert (amiss["status"], amiss["fault"]) == (
        "degraded",
        "The database could not be backed up. See the log for the reason.",
    )
    (copy,) = (tmp_path / "away").glob("*.sqlite3")
    assert verify_left(copy).findings == ()


@pytest.fixture
def small_pages(monkeypatch):
    monkeypatch.setattr(visiting, "_LINKS", 4)
    monkeypatch.setattr(journal, "_MOST_CHARACTERS", 500)


async def read(plant, *wanted):
    """Read a journal to its end, page by page."""
    found, after = [], 0
    while after is not None:
        part = await JournalLines(plant.database).of(wanted[0], Page(after, 3), *wanted[1:])
        found += part
        after = part.next_after
    assert part.total == len(found)
    return found


@pytest.mark.usefixtures("small_pages")
async def test_what_a_lost_cell_measured_is_still_read_in_the_plant(address, opened, cell):
    plant = opened(address())
    await cell.measure(3)
    await plant.visit(cell)
    newest = await cell.newest()
    there = await cell.database.read(
        lambda c: [tuple(row) for row in c.exec_driver_sql("SELECT id, session_id, document FROM readings")]
    )

    found = await read(plant, "left arm")
    readings = await read(plant, "left arm", "readings")

    assert [line.link for line in found] == [*range(1, newest + 1)]
    kept = [(line.row["id"], line.row["session_id"], json.loads(line.row["document"])) for line in readings]
    assert kept == [(id_, session, json.loads(document)) for id_, session, document in there]
    assert [line for line in found if line.record == "readings"] == readings
    assert await read(plant, "right arm") == []
