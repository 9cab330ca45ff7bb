"""What can be made again and is kept beside the database: rendered pages, the newest comparison of robots.

Nothing of it is a record. The folder of renderings may be thrown away at any time, is in no copy of the
database, and a disk that is nearly full gets nothing of it. A file is named after what it was drawn of and
begins with the hash of what it holds: one that a lost power cut short is none.

A comparison of the robots of a type follows from campaigns that are records, and a new one comes to the same.
Pages say of it what they need at once, and never wait for a comparison.
"""

import asyncio
import contextlib
import hashlib
import json
import os
import shutil
import threading
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import DamagedDatabaseError

MOST_BYTES: Final = 64 * 2**20  # some five hundred pages and reports
_ROOM_BYTES: Final = 512 * 2**20  # that the disk has left for records whatever is kept here
_HASH_BYTES: Final = hashlib.sha256().digest_size


@dataclass(frozen=True, slots=True)
class RenderedPage:
    """A page, a part of one or a printed report, and the hash that names its content."""

    body: bytes
    sha256: str


class DrawnFolder:
    """What was drawn; every method touches the disk, so call them off the loop."""

    def __init__(self, folder: Path, most_bytes: int = MOST_BYTES, room_bytes: int = _ROOM_BYTES) -> None:
        self._folder = folder
        self._most_bytes = most_bytes
        self._room_bytes = room_bytes
        self._lock = threading.Lock()

    @classmethod
    def beside(cls, database: Path) -> "DrawnFolder":
        """Return what a service drew by the file of its database."""
        return cls(database.with_name(f"{database.name}.drawn"))

    def get(self, of: str) -> RenderedPage | None:
        """Return what was drawn of something; None where it was not, or is not kept any more."""
        # A name says what was drawn, and may hold anything: its hash is a file's name on every system.
        file = self._file(of)
        try:
            kept = file.read_bytes()
            os.utime(file)  # what is looked at stays longest
        except OSError:
            return None
        drawn = rendered_page(kept[_HASH_BYTES:])
        return drawn if kept[:_HASH_BYTES].hex() == drawn.sha256 else None

    def keep(self, of: str, drawn: RenderedPage) -> None:
        """Keep what was drawn, if the disk has room to spare."""
        # What can be made again is never worth an error: whoever asked has the page already.
        with self._lock, contextlib.suppress(OSError):
            self._folder.mkdir(mode=0o700, exist_ok=True)
            # Readings come first: the last 512 MB of a disk are for records.
            if shutil.disk_usage(self._folder).free < self._room_bytes:
                return
            # One name for all, so that what a crash cut short is written over by the next, and no such file
            # is ever left to grow old.
            part = self._folder / "part"
            part.write_bytes(bytes.fromhex(drawn.sha256) + drawn.body)
            os.replace(part, self._file(of))
            self._make_room()

    def _make_room(self) -> None:
        """Remove what nobody has looked at for longest, down to what may be kept."""
        newest_first = sorted(
            (
                (entry.stat().st_mtime_ns, entry.stat().st_size, entry.path)
                for entry in os.scandir(self._folder)
            ),
            reverse=True,
        )
        kept_bytes = 0
        # By the time of the last look, which `get` renews: pages of a session under way outlast those of last
        # year.
        for _, size_bytes, path in newest_first:
            kept_bytes += size_bytes
            if kept_bytes > self._most_bytes:
                os.unlink(path)

    def _file(self, of: str) -> Path:
        return self._folder / hashlib.sha256(of.encode()).hexdigest()


def rendered_page(body: bytes) -> RenderedPage:
    """Return what was drawn with its hash."""
    return RenderedPage(body, hashlib.sha256(body).hexdigest())


_MOST_BYTES: Final = 64 * 2**20  # some thousands of types


@dataclass(frozen=True, slots=True)
class LimitForecast:
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
class FleetComparison:
    """The robots of a type as they were compared last."""

    robot: str  # the type
    computed_at: str
    newest: int  # result: of the campaigns that were compared, the one that was collected last
    limit_mm: float
    foreseen: tuple[LimitForecast, ...]  # empty: nothing of any robot comes to the limit


class Comparisons:
    """The newest comparison of each type, kept beside the database and remembered."""

    def __init__(self, database: Path) -> None:
        self._folder = DrawnFolder(database.with_name(f"{database.name}.compared"), _MOST_BYTES)
        self._known: dict[str, FleetComparison | None] = {}

    async def of(self, types: Iterable[str]) -> list[FleetComparison]:
        """Return the newest comparison of each type that was ever compared."""
        wanted = sorted({*types})
        for robot in wanted:
            if robot not in self._known:
                found = await asyncio.to_thread(self._read, robot)
                # While that was read a newer one may have been kept, which stays.
                self._known.setdefault(robot, found)
        return [found for robot in wanted if (found := self._known[robot]) is not None]

    async def keep(self, data: bytes) -> None:
        """Keep a comparison as it travels, in the place of one of its type that knew no later campaign."""
        compared = from_bytes(data)
        if compared is None:
            return
        # A worker that was away compares fewer campaigns than are known; its comparison must not replace a
        # newer one (decision 0069).
        if all(known.newest <= compared.newest for known in await self.of([compared.robot])):
            self._known[compared.robot] = compared
            await asyncio.to_thread(self._folder.keep, _of(compared.robot), rendered_page(data))

    def _read(self, robot: str) -> FleetComparison | None:
        kept = self._folder.get(_of(robot))
        return None if kept is None else from_bytes(kept.body)


def to_bytes(compared: FleetComparison) -> bytes:
    """Return a comparison as it travels and is kept: one line."""
    return json.dumps(to_document(compared)).encode()


def from_bytes(data: bytes) -> FleetComparison | None:
    """Return a comparison; None: another version kept it in another form."""
    try:
        return from_document(FleetComparison, json.loads(data))
    # A file of another version is no comparison: the next one that somebody opens makes it anew.
    except (DamagedDatabaseError, ValueError):
        return None


def _of(robot: str) -> str:
    return f"compared {robot}"
