"""What everybody in the day works with."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.studies.managers_day.cells import CellAtWork
from tests.studies.managers_day.diary import Diary
from tests.studies.managers_day.pages import Looking
from tests.studies.managers_day.plants import Kept, PlantAtWork


@dataclass(slots=True)
class Day:
    """Two cells, their plant, a screen in the manager's office, and the diary."""

    out: Path
    diary: Diary
    plant: PlantAtWork
    screen: Looking
    cells: list[CellAtWork]
    heads: dict[str, str] = field(default_factory=dict)  # of cells, when all was collected
    kept: list[Kept] = field(default_factory=list)  # by the plant, so far

    async def collected(self) -> None:
        """Wait until the plant has all of every cell: each link once, in order, nothing less than before."""
        for cell in self.cells:
            self.heads[cell.name] = await self.plant.has_all_of(cell)
            self.diary.saw(f"{cell.name}: up to date, chain head {self.heads[cell.name]}")
        self.look_through_journal()

    def look_through_journal(self) -> None:
        """Assert that the journal has nothing twice or out of order, and everything that it had."""
        journal = self.plant.journal()
        assert journal[: len(self.kept)] == self.kept, "something that was collected is not there as it was"
        assert_once_and_in_order(journal)
        self.kept = journal


def assert_once_and_in_order(journal: list[Kept]) -> None:
    """Assert that the links of each branch follow each other, from the first that it has."""
    seen: Counter[int] = Counter()
    for _, branch, link, _ in journal:
        assert seen[branch] in {0, link - 1}, f"link {link} of branch {branch} follows {seen[branch]}"
        seen[branch] = link
