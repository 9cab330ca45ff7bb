"""Morning: cells and plant are set up as the pages for integrators say, and both robots are measured."""

import asyncio

from tests.studies.managers_day.cells import CellAtWork, measure_by_ballbar, measure_by_tracker, verdict_on
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.plants import MANAGER, METROLOGIST
from tests.studies.managers_day.programs import answered


async def set_up(day: Day) -> None:
    """Have two cells and their plant run."""
    plant, (first, second) = day.plant, day.cells
    with day.diary.step("Two cells are set up, each with a scheduled backup on another disk"):
        for cell in day.cells:
            await cell.set_up(plant.tokens_file(cell))
        await asyncio.gather(*(cell.start() for cell in day.cells))
        for cell in day.cells:
            await cell.cable.plug_in()
        day.diary.saw(f"{first.name} with robot {first.robot}, {second.name} with robot {second.robot}")
    with day.diary.step("The plant is set up on a PostgreSQL server; people are entered while it runs"):
        plant.make_database()
        plant.name_cells(day.cells)
        await plant.start()
        await plant.enter("Ada Byron", "administrator")
        await plant.enter(METROLOGIST, "metrologist")
        link = await plant.enter(MANAGER, "viewer")
        await day.screen.choose_password(link)
        seen = await day.screen.at(plant.url, "the-plant-is-empty")
        assert "No robots yet" in seen, seen
        await day.collected()


async def both_measure(day: Day) -> None:
    """Have both robots measured, each by tracker and ballbar."""
    with day.diary.step("Both cells measure by tracker and ballbar, identify, validate, diagnose"):
        for told in await asyncio.gather(*map(_measured, day.cells)):
            day.diary.saw(told)
        await day.collected()
        robots = {robot["serial_number"]: robot for robot in await day.plant.everything("robots")}
        assert all(robots[cell.robot]["last_measured_on"] for cell in day.cells), robots
        await day.screen.at(day.plant.url, "the-plant-at-a-glance")
        life = await day.screen.at(f"{day.plant.url}/robots/{day.cells[0].robot}", "a-robots-life")
        assert "morning" in life, life


async def _measured(cell: CellAtWork) -> str:
    async with cell.at_the_tablet() as client:
        measured = await measure_by_tracker(client, "morning", cell.seed)
        verdict = await verdict_on(client, measured.campaign)
        await measure_by_ballbar(client, "morning, ballbar", cell.seed)
        return f"{cell.robot}: {measured.told}, diagnosis: {verdict}"


async def closing_time(day: Day) -> None:
    """End all services, verify every database, and move the plant's records to a file."""
    with day.diary.step("Closing time: everything is ended, verified, and the plant's records are copied"):
        for cell in day.cells:
            await cell.stop()
            verified = await answered("verify", str(cell.database), "--head", day.heads[cell.name])
            assert verified["whole"], verified
            day.diary.saw(f"{cell.name}: {verified['records']} records, none changed since it was written")
        await day.plant.stop()
        file = day.out / "plant.sqlite3"
        copied = await answered("copy", day.plant.database, str(file))
        verified = await answered("verify", str(file), "--head", copied["head"])
        assert verified["whole"], verified
        day.diary.saw(f"plant: {copied['records']} records copied from the server to {file.name}, verified")
