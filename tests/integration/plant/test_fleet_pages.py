"""Robots of a type compared on a plant's page, and the courses of a robot's life."""

import asyncio
import contextlib
import json
import re
from datetime import date

import numpy as np
import pytest

from tests.helpers.archive import ThisProcess
from tests.integration.plant.test_plant_pages import lay, page, service
from tests.studies.fleet.archive import FIRST
from tests.studies.fleet.simulated import draw_fleet, record_robot
from truepose.analysis.archive import in_database
from truepose.analysis.errors import ClusterError
from truepose.analysis.fleets.campaign_summaries import CampaignSummaryService
from truepose.analysis.fleets.campaigns import tell
from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.analysis.parallel import local_pool
from truepose.analysis.parallel.tasks import Cluster
from truepose.exchange.tables.files import Stated
from truepose.storage.documents import pack
from truepose.storage.plant.outbox import to_typed_json
from truepose.storage.plant.overview import CollectedCampaigns
from truepose.storage.plant.tables import plant_journal, plant_results, plant_robots, plant_told

__all__ = ["service"]  # a fixture
WHOLE = "/fleet?whole=true"


def result(number, serial, day, **more):
    """Return the row of a collected campaign."""
    told = {"kind": "campaign", "link": number, "record_id": number, "name": f"campaign {number}"}
    of = {"robot": "ABB IRB 120", "robot_serial_number": serial, "measured_on": day}
    return plant_results, {"branch_id": 1, **told, **of, "instrument_serial_number": "T-9", **more}


@pytest.fixture(scope="module")
def campaigns():
    """Two robots in two months: in neither anything changes."""
    fleet = draw_fleet(1, 2, ageing=0, drifting=False)
    return [
        (f"A-{robot.number}", FIRST.replace(month=3 + month), record_robot(robot, month, "T-9", fleet, 15))
        for robot in fleet.robots
        for month in (0, 1)
    ]


async def test_a_plant_without_campaigns_says_so(service):
    assert "No campaigns have been collected from any cell yet." in await page(service, "/fleet")


async def test_too_few_robots_are_told_what_is_missing(service):
    nobody = result(3, "", "2026-05-01")
    await lay(service, result(1, "A-1", "2026-03-01"), result(2, "A-2", "2026-03-01"), nobody)

    shown = await page(service, "/fleet")

    assert "Robots so far with a campaign whose robot, instrument and day are known: 2." in shown
    assert "Of these, measured on two days or more: 0." in shown
    assert "the day is in the future: 1." in shown


async def test_a_day_that_has_not_come_is_not_compared(service):
    await lay(
        service,
        *(
            result(2 * n + k, f"A-{n}", day)
            for n in (1, 2)
            for k, day in enumerate(("2026-03-01", "2126-03-01"))
        ),
    )

    shown = await page(service, "/fleet")

    assert "Of these, measured on two days or more: 0." in shown
    assert "the day is in the future: 2." in shown


async def collect(service, campaigns, first=1):
    for number, (serial, day, recorded) in enumerate(campaigns, start=first):
        content = json.dumps(to_typed_json({"campaign": pack(recorded.campaign)}))
        row = {"branch_id": 1, "link": number, "stream": 1, "record": "campaigns", "record_id": number}
        kept = {**row, "hash": b"-", "content": content, "verified": 1}
        await lay(service, (plant_journal, kept), result(number, serial, day.isoformat()))


def told_here(recorded):
    """Return the bits that a campaign tells in this process."""
    return tell(pack(recorded.campaign), np.random.SeedSequence(0))


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request, tmp_path, empty_database):
    """The database of a plant, in a file and on a server."""
    if request.param == "postgresql":
        return request.getfixturevalue("on_server")()
    file = tmp_path / "plant.sqlite3"
    file.write_bytes(empty_database.read_bytes())
    return f"sqlite:///{file}"


async def test_robots_are_compared_from_what_was_collected(address, served_plant, campaigns, monkeypatch):
    monkeypatch.setattr(local_pool, "workers", lambda *_: contextlib.nullcontext(Cluster(ThisProcess())))
    async with served_plant(address) as service:
        await collect(service, campaigns)
        await lay(service, (plant_robots, {"serial_number": "A-0", "robot": "ABB IRB 120"}))

        glances = [await page(service, "/")]
        shown = await page(service, WHOLE)
        glances.append(await page(service, "/"))
        found = await asyncio.to_thread(_archived, address)
        await lay(service, result(5, "A-1", "2026-05-02"))
        glances.append(await page(service, "/"))

    assert "2 robots, 1 instruments and 4 campaigns from 2026-03-02 to 2026-04-02 were compared." in shown
    assert "No significant change" in shown
    assert "would have been detected with 95 % probability if it had reached these sizes" in shown
    assert "Computed on " in shown
    assert "All readings come from a simulated cell" in shown
    assert [one for one, _ in found] == [f"left arm {number} campaign {number}" for number in range(1, 5)]
    assert found[0][1] == Stated("A-0", "T-9", date(2026, 3, 2))

    compared = re.compile(
        r'<a href="/fleet\?type=ABB%20IRB%20120">ABB IRB 120: last compared on .*: (\d+)\.</a>'
    )
    assert [compared.findall(glance) for glance in glances] == [[], ["0"], ["1"]]


def _archived(url):
    """Return names and what is stated of the campaigns in a plant's database; each can be read."""
    with in_database(url) as campaigns:
        assert all(stored_campaign(one.load()).calibration is not None for one in campaigns)
        return [(one.name, one.stated) for one in campaigns]


async def test_workers_that_are_away_keep_nobody_waiting_and_health_says_so(
    tmp_path, empty_database, served_plant, campaigns, unused_tcp_port
):
    database = tmp_path / "plant.sqlite3"
    database.write_bytes(empty_database.read_bytes())
    url, away = f"sqlite:///{database}", f"dask://127.0.0.1:{unused_tcp_port}"
    async with served_plant(url, workers="1") as plant:
        await collect(plant, campaigns[:3])
        by_process = [one.told for one in await plant.here.fleets.told(await plant.here.fleets.campaigns())]
        healthy = (await plant.get("/health")).json()

    async with served_plant(url, workers=away) as plant:
        await collect(plant, campaigns[3:], first=4)
        shown = await page(plant, "/fleet")
        known = await plant.here.fleets.known(await plant.here.fleets.campaigns())
        health = (await plant.get("/health")).json()

    assert by_process == [told_here(recorded) for _, _, recorded in campaigns[:3]]
    assert [one.told for one in known] == by_process
    assert "data-drawing" in shown  # by those that are known
    assert "some campaigns have not been read yet: 1." in shown
    assert f"No Dask scheduler answers at 127.0.0.1:{unused_tcp_port}." in shown
    assert (healthy["status"], health["status"]) == ("ok", "degraded")
    assert health["fault"].startswith("The workers of this plant cannot be used")


class LostAfterOne(ThisProcess):
    """Workers that are lost for good once they have answered."""

    def ended(self):
        if self.performed:
            raise ClusterError("The workers are gone.")
        return super().ended()


class Here:
    """Draws in this process."""

    async def draw(self, function, of):
        return function(of)


async def test_what_came_before_workers_were_lost_is_kept(service, campaigns, monkeypatch):
    monkeypatch.setattr(local_pool, "workers", lambda *_: contextlib.nullcontext(Cluster(LostAfterOne())))
    await collect(service, campaigns)
    database = service.here.database
    desk = CampaignSummaryService(
        CollectedCampaigns(database), CampaignSummaryService.folder(database.file), Here(), "dask://away:1"
    )

    with pytest.raises(ClusterError, match="The workers are gone"):
        await desk.told(await desk.campaigns())

    known = await desk.known(await desk.campaigns())
    assert [one.told for one in known] == [told_here(campaigns[0][2])]
    assert await desk.away() == "The workers are gone."


async def test_a_robots_error_and_causes_are_drawn_over_the_days(service):
    cause = {"effect": "backlash", "subject": "joint 4", "unit": "deg", "amplitude": 0.02}
    found = {"causes": [{**cause, "amplitude_standard_uncertainty": 0.002}]}
    rows = [(plant_robots, {"serial_number": "A-1", "robot": "ABB IRB 120"})]
    for number, kind in enumerate(("identification", "diagnosis") * 2, start=1):
        told = {"branch_id": 1, "kind": kind, "link": number, "record_id": number, "verdict": "converged"}
        of = {"robot_serial_number": "A-1", "measured_on": f"2026-0{2 + number}-01", "figure_mm": 0.05}
        rows.append((plant_told, {**told, **of, "document": found if kind == "diagnosis" else {}}))
    await lay(service, *rows)

    shown = await page(service, "/robots/A-1?whole=true")

    assert shown.count("<svg") >= 2
    assert "backlash, joint 4" in shown
    assert "Mean error of each identification at held-out points" in shown
