"""Evening: who is to be measured next and why, and a plan for that robot handed down."""

import re
from typing import Any, Final
from urllib.parse import urlsplit

from tests.studies.managers_day.cells import CellAtWork, measure_as_planned
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.plants import METROLOGIST
from tests.studies.managers_day.programs import until
from truepose.demo.client import PERSON, ServiceClient

_NEW_SEED: Final = 7
_NEXT: Final = "Measure next"
_FIGURE: Final = re.compile(r"(\d\.\d{3}) mm")
_NUMBER: Final = re.compile(r"\d+\.\d+")
_PLAN: Final = {
    "name": "monthly check",
    "role": "calibration",
    "plan": {"method": "choose", "configurations": 15, "seed": 7},
}


async def ask_who_is_next(day: Day) -> None:
    """Exchange the robot of a cell, see the plant ask for it, and have it measured by a plan handed down."""
    cell, plant = day.cells[1], day.plant
    with day.diary.step(f"{cell.name} gets another robot; the manager asks who is to be measured next"):
        await cell.stop()
        cell.seed = _NEW_SEED
        await cell.start()
        async with cell.at_the_tablet() as client:
            await client.finish_job(await client.plan("of the new robot", "calibration", 5, cell.seed))
        await day.collected()
        await day.screen.at(plant.url, "who-is-next")
        rows = await day.screen.links_of_rows(_NEXT)
        assert len(rows) > 1 and cell.robot in rows[0][0], rows  # and the one that failed its validation
        for text, links in rows:
            day.diary.saw(f"next: {text}")
            for link in links:
                await _defended(day, text, link)
    with day.diary.step(f"A plan for {cell.robot} is handed down; a person at {cell.name} uses it"):
        wanted = {
            "cell": cell.name,
            "kind": "plan",
            "name": _PLAN["name"],
            "person": METROLOGIST,
            "document": _PLAN,
        }
        number = (await plant.post("/plant/hand-downs", wanted, METROLOGIST))["id"]

        async def delivered() -> dict[str, Any] | None:
            found: dict[str, Any] = await plant.get(f"/plant/hand-downs/{number}")
            return found if found["state"] == "delivered" else None

        await until(delivered, "the plan is delivered")
        async with cell.at_the_tablet() as client:
            await _used(day, cell, client)
        await day.collected()
        page = await day.screen.at(f"{plant.url}/robots/{cell.robot}", "measured-as-asked")
        assert _PLAN["name"] in page, page
        await day.screen.at(plant.url, "nobody-is-next")
        assert not any(cell.robot in text for text, _ in await day.screen.links_of_rows(_NEXT))


async def _defended(day: Day, reason: str, link: str) -> None:
    """Follow a link of a reason to the record that says so, and see its figure there."""
    if link.startswith("/"):
        page = await day.screen.at(f"{day.plant.url}{link}", "a-robot-that-is-due")
        assert link.rpartition("/")[2] in page, page
        return
    cell = next(cell for cell in day.cells if link.startswith(f"http://127.0.0.1:{cell.cable.port}/"))
    page = await day.screen.elsewhere(f"{link}?whole=true", cell.token_of_viewer, "the-record-behind-it")
    figure = _FIGURE.search(reason)
    assert figure is not None, reason
    shown = [number for number in _NUMBER.findall(page) if f"{float(number):.3f}" == figure[1]]
    assert shown, f"{link} does not show {figure[1]} mm"
    day.diary.saw(f"  {urlsplit(link).path} of {cell.name} shows {shown[0]} mm")


async def _used(day: Day, cell: CellAtWork, client: ServiceClient) -> None:
    """Plan a session with what was handed down, measure it, and put on record what it was used for."""
    handed = (await client.get("/hand-downs"))[-1]
    await client.connect_devices()
    job = await cell.post("/sessions", handed["document"])
    session = await client.finish_job(job["id"])
    measured = await measure_as_planned(client, handed["name"], session, cell.seed)
    note = f"Session {session} was planned with it."
    await cell.post(f"/hand-downs/{handed['id']}/uses", {"person": PERSON, "note": note})
    day.diary.saw(f"at the cell: {note} Then: {measured.told}")
