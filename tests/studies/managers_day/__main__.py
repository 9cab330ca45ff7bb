"""A maintenance manager's day: two cells, a plant on PostgreSQL, Dask with two workers, on one machine.

    python -m tests.studies.managers_day --out out/managers-day

Everything is done as a user does it: by commands, over REST and in a browser. What is pulled, lost and killed
is what may happen; each step says what the manager sees and how long it took. The pages are kept as pictures.
"""

import asyncio
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.helpers.postgresql.server import own_server
from tests.studies.managers_day.asking import ask_who_is_next
from tests.studies.managers_day.cells import CellAtWork
from tests.studies.managers_day.computing import compute_anew
from tests.studies.managers_day.cutting_off import lose_a_disk, pull_the_cable
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.diary import Diary
from tests.studies.managers_day.keeping import lose_the_plants_database, stop_the_server
from tests.studies.managers_day.pages import looking
from tests.studies.managers_day.plants import PlantAtWork
from tests.studies.managers_day.setting_up import both_measure, closing_time, set_up
from tests.studies.running import study_options

_STEPS = (
    set_up,
    both_measure,
    pull_the_cable,
    lose_a_disk,
    stop_the_server,
    lose_the_plants_database,
    ask_who_is_next,
    compute_anew,
    closing_time,
)


async def walk(folder: Path, out: Path, diary: Diary) -> None:
    """Go through the day."""
    with own_server() as server:
        async with looking(out) as screen:
            (folder / "plant").mkdir()
            plant = PlantAtWork(folder / "plant", server)
            cells = [CellAtWork(f"Cell {n}", folder / f"cell-{n}", seed=n) for n in (1, 2)]
            day = Day(folder, diary, plant, screen, cells)
            try:
                for step in _STEPS:
                    await step(day)
            except BaseException:
                shutil.copytree(folder, out / "left", dirs_exist_ok=True)
                raise
            finally:
                for service in (plant.service, *(cell.service for cell in cells)):
                    if service is not None:
                        await service.kill()
                for cell in cells:
                    await cell.cable.switch_off()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    out = study_options(__doc__, arguments, out=Path).out
    out.mkdir(parents=True, exist_ok=True)
    diary = Diary()
    with tempfile.TemporaryDirectory(prefix="managers-day-") as folder:
        os.environ["XDG_DATA_HOME"] = folder  # what lies beside a server's database
        try:
            asyncio.run(walk(Path(folder), out, diary))
        finally:
            diary.write(out / "managers_day.json")
    return 0


if __name__ == "__main__":
    sys.exit(main())
