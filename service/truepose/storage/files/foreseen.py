"""What the newest comparison of robots of a type foretells, until a newer one: a file beside the database.

It is no record: it follows from campaigns that are, and a new comparison comes to the same. Pages say of it
what they need at once, and never wait for a comparison.
"""

import asyncio
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from truepose.storage.files.drawn import DrawnFolder, drawn_of

_MOST_BYTES: Final = 64 * 2**20  # some thousands of types


@dataclass(frozen=True, slots=True)
class Foreseen:
    """A robot of which a change has passed a limit, or will."""

    robot: str  # its serial number
    effect: str  # what changes
    subject: str
    order: float  # periods per turn of a wave; 0: it is none
    since: str  # a day
    size_mm: float  # to which it had come
    rate_mm: float | None  # a month; None: it changed at once
    last_measured_on: str  # among what was compared
    day: str | None = None  # on which the limit is passed, half of the probability before it
    earliest: str | None = None  # 5 %


@dataclass(frozen=True, slots=True)
class Compared:
    """The robots of a type as they were compared last."""

    robot: str  # the type
    computed_at: str
    newest: int  # result: of the campaigns that were compared, the one that was collected last
    limit_mm: float
    foreseen: tuple[Foreseen, ...]  # empty: nothing of any robot comes to the limit


class Comparisons:
    """The newest comparison of each type, kept beside the database and remembered."""

    def __init__(self, database: Path) -> None:
        self._folder = DrawnFolder(database.with_name(f"{database.name}.compared"), _MOST_BYTES)
        self._known: dict[str, Compared | None] = {}

    async def of(self, types: Iterable[str]) -> list[Compared]:
        """Return the newest comparison of each type that was ever compared."""
        wanted = sorted({*types})
        for robot in wanted:
            if robot not in self._known:
                self._known[robot] = await asyncio.to_thread(self._read, robot)
        return [found for robot in wanted if (found := self._known[robot]) is not None]

    async def keep(self, data: bytes) -> None:
        """Keep a comparison as it travels, in the place of one of its type that knew no later campaign."""
        compared = from_bytes(data)
        if compared is None:
            return
        if all(known.newest <= compared.newest for known in await self.of([compared.robot])):
            self._known[compared.robot] = compared
            await asyncio.to_thread(self._folder.keep, _of(compared.robot), drawn_of(data))

    def _read(self, robot: str) -> Compared | None:
        kept = self._folder.get(_of(robot))
        return None if kept is None else from_bytes(kept.body)


def to_bytes(compared: Compared) -> bytes:
    """Return a comparison as it travels and is kept: one line."""
    return json.dumps(asdict(compared)).encode()


def from_bytes(data: bytes) -> Compared | None:
    """Return a comparison; None: another version kept it in another form."""
    try:
        found = json.loads(data)
        return Compared(**{**found, "foreseen": tuple(Foreseen(**one) for one in found["foreseen"])})
    except (KeyError, TypeError, ValueError):
        return None


def _of(robot: str) -> str:
    return f"compared {robot}"
