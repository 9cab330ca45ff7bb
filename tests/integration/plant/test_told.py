"""What results tell is kept beside them."""

import dataclasses
from datetime import date

import pytest
from sqlalchemy import select

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.domain.tracker_sessions import make_plan, make_setup
from tests.helpers.storage.demo_database import write_demo
from tests.integration.web.bench import CELL
from truepose.domain.cell import Artefact, DeviceEntry
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.plant.certificates import PlantCertificates
from truepose.storage.plant.overview import PlantResults
from truepose.storage.plant.tables import plant_robots, plant_told
from truepose.storage.record_insertion import add_row
from truepose.storage.records import CampaignSummary, JobKind
from truepose.storage.results.campaigns import CampaignRepository, NewCampaign
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.jobs import JobRepository

DAY = date(2026, 5, 4)


async def test_results_tell_their_figures_and_what_the_robot_carried(open_cell, plant, tmp_path):
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "cell.toml").write_text(CELL)
    write_demo(tmp_path / "cell" / "truepose.sqlite3")
    async with open_cell() as cell:
        await plant.visit(cell)

    rows = {row.kind: row for row in await plant.database.read(lambda c: c.execute(select(plant_told)).all())}
    validation = rows["validation"]
    assert (validation.verdict, validation.document["promised"]) == ("no_limit", True)
    assert [round(validation.document[name], 4) for name in ("before_mm", "after_mm")] == [1.1717, 0.0311]
    assert round(validation.figure_mm, 4) == 0.0311
    assert round(validation.limit_mm, 4) == 0.0301
    assert (rows["diagnosis"].verdict, rows["diagnosis"].document["causes"]) == ("consistent", [])
    assert rows["model"].document["tool"] == rows["session"].document["tool"]
    assert rows["session"].document["tool"] == "triangular artefact, simulated"


async def test_what_was_brought_with_a_serial_number_stands_in_the_life_of_its_robot(plant, cell):
    said = {"robot_serial_number": "120-9", "instrument_serial_number": "T-9", "certificate": "report 9"}
    summary = CampaignSummary(30, 0, 0, 0, 0, measured_on="2026-03-03")
    stored = CampaignRepository(cell.database)
    number = await stored.add(NewCampaign("told", "arm", dataclasses.replace(summary, **said), b"", b"zip"))
    await stored.add(NewCampaign("silent", "arm", summary, b"", b"zip"))
    jobs = JobRepository(cell.database)
    job = await jobs.add(JobKind.DIAGNOSIS, {"campaign_id": number})
    found = make_diagnosis(robot="arm")
    await DiagnosisRepository(cell.database).keep(job, number, found, None)

    await plant.visit(cell)

    life = [(one.kind, one.name, one.measured_on) for one in await plant.looks.life_of_robot("120-9")]
    assert {("campaign", "told", "2026-03-03"), ("diagnosis", "told", "2026-03-03")} <= {*life}
    assert [one.name for one in await plant.looks.life_of_instrument("T-9")] != []
    (paper,) = await PlantCertificates(plant.database).of_instrument("T-9")
    assert paper.paper.certificate == "report 9"


async def test_the_newest_of_a_robot_is_the_one_that_was_measured_last(plant, cell):
    told = PlantResults(plant.database)
    await plant.journal.enter("left arm")

    async def came(link, kind, day, robot="120-1"):
        of = {"robot_serial_number": robot, "measured_on": day, "verdict": "", "document": {}}
        values = {"branch_id": 1, "kind": kind, "link": link, "record_id": link, **of}
        await plant.database.write(lambda c: add_row(c, plant_told, **values))
        return {kind: one.record_id for kind, one in (await told.newest(DAY)).get("120-1", {}).items()}

    await plant.database.write(lambda c: add_row(c, plant_robots, serial_number="120-1", robot="arm"))
    found = [
        await came(1, "model", "2026-03-03"),
        await came(2, "validation", "2026-03-04"),
        await came(3, "model", "2026-01-01"),  # of an earlier day, collected later
        await came(4, "model", "2026-03-03", robot="120-2"),
        await came(5, "model", "2026-03-03"),
        await came(6, "model", "2042-01-01"),  # by a clock that was wrong
    ]

    assert found == [{"model": 1}, *[{"model": 1, "validation": 2}] * 3, *[{"model": 5, "validation": 2}] * 2]
    anew = (await PlantResults(plant.database).newest(DAY))["120-1"]
    assert {kind: one.record_id for kind, one in anew.items()} == found[-1]


async def state(cell, serial, certificate, expires, tool=None):
    """Plan a session in a cell whose file states a certificate of its tracker."""
    tracker = DeviceEntry("tracker", "fake_tracker", {}, serial, certificate, expires)
    setup = make_setup()
    cell_then = dataclasses.replace(setup.cell, devices=(tracker,), tool=tool)
    await SessionRepository(cell.database).add("s", dataclasses.replace(setup, cell=cell_then), make_plan())


async def test_certificates_follow_the_serial_number(plant, cell):
    await state(cell, "T-7", "report 1", "2026-03-31", Artefact("ball plate", "", "P 9", "2027-01-31"))
    await state(cell, "T-7", "report 2", "2027-03-31", Artefact("ball plate", "", "P 9", "2027-01-31"))
    await state(cell, "T-7", "report 1", "2026-03-31")  # an older cell file
    await state(cell, "T-8", "", "")

    await plant.visit(cell)

    certificates = PlantCertificates(plant.database)
    of_instrument = await certificates.of_instrument("T-7")
    assert [one.paper.certificate for one in of_instrument] == ["report 2", "report 1"]
    counting = [(one.paper.of, one.paper.expires, one.cell) for one in await certificates.that_count()]
    assert counting == [("ball plate", "2027-01-31", "left arm"), ("tracker", "2027-03-31", "left arm")]
    assert await certificates.of_instrument("T-8") == []


def identification(number, serial, measured_on, known_since):
    """Return the row of what an identification tells, and since when the plant has known it."""
    of = {"branch_id": 1, "kind": "identification", "link": number, "record_id": number}
    told = {"verdict": "converged", "figure_mm": 0.05, "limit_mm": None, "document": {}}
    when = {"measured_on": measured_on, "recorded_at": f"{known_since}T12:00:00.000+00:00"}
    return {**of, **told, **when, "robot_serial_number": serial}


@pytest.mark.parametrize("looked_before", [False, True], ids=["read at once", "read as it came"])
async def test_what_was_known_before_a_day_is_told_from_what_is_known_now(open_plant, looked_before):
    since = date(2026, 5, 4)
    known = [
        identification(1, "old", "2026-03-01", "2026-03-01"),
        identification(2, "delivered late", "2026-03-01", "2026-03-01"),
    ]
    came = [
        identification(3, "delivered late", "2026-04-01", "2026-05-06"),
        identification(4, "collected anew", "2026-03-01", "2026-05-06"),
        identification(5, "collected anew", "2026-04-01", "2026-05-06"),
        identification(6, "collected anew", "2026-05-06", "2026-05-06"),
        identification(7, "measured first", "2026-05-05", "2026-05-06"),
    ]
    with open_plant() as plant:
        await plant.journal.enter("left arm")
        told = PlantResults(plant.database)

        async def lay(*rows):
            for row in rows:
                await plant.database.write(lambda c, row=row: add_row(c, plant_told, **row))

        for serial in ("old", "delivered late", "collected anew", "measured first"):
            named = {"serial_number": serial, "robot": "IRB 120"}
            await plant.database.write(lambda c, named=named: add_row(c, plant_robots, **named))
        await lay(*known)
        if looked_before:
            await told.before(since)
        await lay(*came)

        before, now = await told.before(since), await told.newest(since)

    assert {serial: found["identification"].record_id for serial, found in before.items()} == {
        "old": 1,
        "delivered late": 2,
        "collected anew": 5,
    }
    assert {serial: found["identification"].record_id for serial, found in now.items()} == {
        "old": 1,
        "delivered late": 3,
        "collected anew": 5,
        "measured first": 7,
    }
