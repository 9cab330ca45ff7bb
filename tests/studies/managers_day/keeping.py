"""Noon: the plant's own server and database fail."""

from tests.studies.managers_day.cells import measure_by_ballbar
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.plants import METROLOGIST
from tests.studies.managers_day.programs import answered, until


async def stop_the_server(day: Day) -> None:
    """Have PostgreSQL go away under the plant, and come back."""
    cell, plant = day.cells[0], day.plant
    with day.diary.step("The PostgreSQL server is stopped under the plant, and started again"):
        plant.server.stop()

        async def refused() -> int | None:
            found = await plant.status("/api/v1/plant/cells")
            return found if found >= 500 else None

        day.diary.saw(f"the plant answers {await until(refused, 'the plant says so')}")
        page = await day.screen.at(plant.url, "the-server-is-away")
        day.diary.saw(next(line for line in page.splitlines() if "does not respond" in line))
        async with cell.at_the_tablet() as client:
            await measure_by_ballbar(client, "without the server", 40 + cell.seed)
        plant.server.restart()
        await day.collected()


async def lose_the_plants_database(day: Day) -> None:
    """Lose everything that the plant has, restore a backup, and collect the rest again."""
    cell, plant, file = day.cells[0], day.plant, day.out / "plant-backup.sqlite3"
    with day.diary.step("The plant is backed up while it runs; its database is lost and restored"):
        made = await answered("backup", str(file), "--database", plant.database, "--replace")
        day.diary.saw(f"{made['records']} records, {made['bytes'] / 1e6:.1f} MB, verified")
        async with cell.at_the_tablet() as client:
            await measure_by_ballbar(client, "after the plant's backup", 50 + cell.seed)
        await day.collected()
        before = [kept[0::2] for kept in day.kept]
        await plant.stop()
        plant.make_database()
        restored = await answered("restore", str(file), "--database", plant.database)
        assert restored["head"] == made["head"], (restored, made)
        day.kept = []
        await plant.start()
        await plant.get("/plant/cells", METROLOGIST)
        await day.collected()
        lost = {kept[0::2] for kept in day.kept} ^ {*before}
        assert not lost, f"{len(lost)} links are not as they were"
        day.diary.saw(f"{len(day.kept)} links, all that was there before it was lost, each once")
