"""Forenoon: the cable of a cell is pulled, and the disk of another is lost."""

from tests.studies.managers_day.cells import STRICT_MM, measure_by_ballbar, measure_by_tracker, newest
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.plants import METROLOGIST
from tests.studies.managers_day.programs import answered, until

_CUT_AFTER_BYTES = 8_000
_CUTS = 3


async def pull_the_cable(day: Day) -> None:
    """Cut a cell off, have it measure, and plug it in again by a cable that breaks in every answer first."""
    cell, plant = day.cells[0], day.plant
    before = len(plant.journal())
    with day.diary.step(f"The cable of {cell.name} is pulled; the cell goes on measuring"):
        cell.cable.pull()
        async with cell.at_the_tablet() as client:
            measured = await measure_by_tracker(client, "cut off", 10 + cell.seed)
        day.diary.saw(f"at the cell: {measured.told}, nobody waited")
        await cell.cable.switch_off()
        visit = await plant.says(cell, "unreachable")
        day.diary.saw(f"at the plant: {visit['sentence']}")
        async with cell.at_the_tablet() as client:
            await measure_by_ballbar(client, "cut off, ballbar", 10 + cell.seed)
        page = await day.screen.at(plant.url, "a-cell-is-cut-off")
        assert "cannot be reached" in page, page
        assert len([kept for kept in plant.journal()[before:] if kept[0] == cell.name]) == 0
    with day.diary.step(f"{cell.name} is plugged in by a bad cable, which cuts answers, then by a good one"):
        await cell.cable.plug_in(_CUT_AFTER_BYTES)

        async def cut_often() -> bool | None:
            await plant.visit_now(cell)
            return cell.cable.cuts >= _CUTS or None

        await until(cut_often, "answers are cut")
        visit = await plant.says(cell, "unreachable")
        day.diary.saw(f"{cell.cable.cuts} answers cut; the plant: {visit['sentence']}")
        await cell.cable.plug_in()
        await day.collected()
        day.diary.saw(f"{len(day.kept) - before} links since the cable was pulled, each once, in order")


async def lose_a_disk(day: Day) -> None:
    """Lose the records of a cell, restore a backup, and accept that its chain is another now."""
    cell, plant = day.cells[1], day.plant
    results = await plant.everything("models")
    with day.diary.step(f"{cell.name} measures on after a scheduled backup; then its disk is lost"):
        backup = newest(cell.backups)
        assert backup is not None
        async with cell.at_the_tablet() as client:
            await measure_by_ballbar(client, "lost with the disk", 20 + cell.seed)
        await day.collected()
        await cell.lose_disk()
        visit = await plant.says(cell, "unreachable")
        day.diary.saw(f"the plant: {visit['sentence']}")
    with day.diary.step(f"{cell.name} gets a new disk; a scheduled backup is restored"):
        cell.disk.mkdir()
        restored = await answered("restore", str(backup), "--database", cell.url_of_database)
        day.diary.saw(f"{restored['records']} records restored, chain head {restored['head']}")
        await cell.start()
        visit = await plant.says(cell, "another_chain")
        day.diary.saw(f"the plant: {visit['sentence']}")
        page = await day.screen.at(plant.url, "another-chain")
        assert "different hash chain" in page.lower(), page
        day.look_through_journal()
    with day.diary.step("The metrologist accepts the other chain; collection goes on, and nothing is lost"):
        reason = "The disk failed; a scheduled backup was restored."
        body = {"person": METROLOGIST, "reason": reason}
        await plant.post(f"/plant/cells/{cell.name}/branches", body, METROLOGIST)
        async with cell.at_the_tablet() as client:
            measured = await measure_by_tracker(client, "on the new disk", 30 + cell.seed, STRICT_MM)
        day.diary.saw(f"at the cell: {measured.told}, with {STRICT_MM} mm allowed")
        await day.collected()
        now = await plant.everything("models")
        assert now[: len(results)] == results
        assert any(one["name"] == "lost with the disk" for one in await plant.everything("campaigns"))
        day.diary.saw(
            f"{len({branch for name, branch, *_ in day.kept if name == cell.name})} branches of {cell.name}; "
            "what was measured before the disk was lost is in the plant alone"
        )
