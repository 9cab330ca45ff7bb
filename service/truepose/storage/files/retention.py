"""What may go: nothing that was recorded, and of what lies beside the database only what nobody can miss.

Readings, acts, results and the uploads that they came from are records: they are in the chain, and stay. Live
values are never stored. What is left are old logs, surplus copies, and what an interrupted copy left behind.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.storage.backup.drafts import drafts_beside
from truepose.storage.backup.schedule import copies_in

_DAY_S: Final = 86400.0
_LEFT_BEHIND: Final = (".part", ".rescued", ".restored")
_SURELY_LEFT_S: Final = _DAY_S  # no copy takes so long


@dataclass(frozen=True, slots=True)
class Rules:
    """How long what may go is kept."""

    logs_days: float = 90.0
    copies: Path | None = None  # folder of the copies on a schedule
    keep_copies: int = 7


@dataclass(frozen=True, slots=True)
class Surplus:
    """A file that may go, and why."""

    file: Path
    size_bytes: int
    why: str


def surplus(database: Path, rules: Rules, now_s: Callable[[], float] = time.time) -> list[Surplus]:
    """Return the files that may go, beside a database and among its copies."""
    found = [*_old_logs(database, rules, now_s()), *_left_behind(database, now_s())]
    if rules.copies is not None:
        found += _surplus_copies(rules.copies, rules.keep_copies)
    return [Surplus(file, file.stat().st_size, why) for file, why in found]


def drop(found: list[Surplus]) -> None:
    """Remove files that may go."""
    for one in found:
        one.file.unlink(missing_ok=True)


def _old_logs(database: Path, rules: Rules, now_s: float) -> Iterator[tuple[Path, str]]:
    for file in sorted(database.parent.glob(f"{database.name}.log.*")):
        days = (now_s - file.stat().st_mtime) / _DAY_S
        if days > rules.logs_days:
            yield file, f"log, {days:.0f} days old"


def _left_behind(database: Path, now_s: float) -> Iterator[tuple[Path, str]]:
    for ending in _LEFT_BEHIND:
        file = database.with_name(f"{database.name}{ending}")
        if file.exists() and now_s - file.stat().st_mtime > _SURELY_LEFT_S:
            yield file, "left behind by a copy that was interrupted"


def _surplus_copies(folder: Path, keep: int) -> Iterator[tuple[Path, str]]:
    for _, file in copies_in(folder)[:-keep]:
        yield file, f"copy, older than the {keep} that are kept"
        if drafts_beside(file).exists():
            yield drafts_beside(file), "drafts of such a copy"
