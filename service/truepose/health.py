"""The health of the service: everything that whoever runs it watches, in one look."""

import asyncio
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Final

from truepose.domain.cell import Artefact, Cell
from truepose.sessions.devices import DeviceRegistry, DeviceStatus
from truepose.storage.backup.schedule import BackupSchedule
from truepose.storage.contents import Counts, record_counts
from truepose.storage.database import Database
from truepose.storage.engine.backend import Integrity
from truepose.storage.errors import ServerAwayError, ServerRefusedError, StorageError


@dataclass(frozen=True, slots=True)
class DeviceLink:
    """How a device of the cell is reached."""

    connected: bool = False
    fault: str = ""  # of the last attempt; empty: none
    foreign: bool = False  # another device answered than the cell file names


@dataclass(frozen=True, slots=True)
class Clock:
    """The computer's clock: records have their order without it, and their dates from it."""

    moved_s: float = 0.0  # set since the start
    ahead_s: float | None = None  # of the newest record; negative: that is of a later time


@dataclass(frozen=True, slots=True)
class Copies:
    """Copies on a schedule."""

    every_s: float
    age_s: float | None = None  # of the newest; None: there is none
    fault: str = ""  # of the last attempt; empty: none


@dataclass(frozen=True, slots=True)
class Records:
    """The database."""

    readable: bool = True
    late: bool = False  # it did not answer the look; counts are those of an earlier one
    refused: str = ""  # why records are refused; empty: they are taken
    reserve_used: bool = False
    commit_s: float | None = None  # as it usually is of late
    free_bytes: int = 0
    size_bytes: int = 0
    integrity: Integrity = "not_checked"
    checked_share: float = 0.0
    damage: str = ""  # empty: none was found
    unchecked: str = ""  # why the last look at every record was not finished; empty: it was
    links: int = 0
    readings: int = 0
    server_doubts: tuple[str, ...] | None = None  # settings that are off on the server; None: a file


@dataclass(frozen=True, slots=True)
class State:
    """The service at one moment."""

    simulated: bool = False
    records: Records = field(default_factory=Records)
    sessions: Mapping[str, int] = field(default_factory=dict)  # by state
    jobs: Mapping[str, int] = field(default_factory=dict)  # by state
    job_seconds: Mapping[str, tuple[int, float]] = field(
        default_factory=dict
    )  # by kind: ended, and their work
    devices: Mapping[str, DeviceLink] = field(default_factory=dict)
    clock: Clock = field(default_factory=Clock)
    certificates: Mapping[str, int] = field(default_factory=dict)  # days left, by artefact
    uncertified: tuple[str, ...] = ()  # artefacts of which nobody said until when their certificate holds
    copies: Copies | None = None  # None: no schedule
    memory_bytes: int = 0
    lines_lost: int = 0  # of the log


def days_left(cell: Cell, today: date) -> dict[str, int]:
    """Return the days until each certificate of a cell expires that says when; negative: it has."""
    return {
        artefact.name: (date.fromisoformat(artefact.certificate_expires) - today).days
        for artefact in _artefacts(cell)
        if artefact.certificate_expires
    }


def without_end(cell: Cell) -> tuple[str, ...]:
    """Return the artefacts of which nobody said until when their certificate holds."""
    return tuple(artefact.name for artefact in _artefacts(cell) if not artefact.certificate_expires)


def _artefacts(cell: Cell) -> Iterator[Artefact]:
    yield from (artefact for artefact in (cell.tool, cell.world) if artefact is not None)
    if cell.ballbar is not None:
        yield from (cell.ballbar.instrument, cell.ballbar.calibrator)


_RESIDENT = 1  # field of statm: pages in the computer's memory


def free_bytes(folder: Path) -> int:
    """Return how much room is left where a folder lies; 0 where it is gone."""
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return 0


if sys.platform == "linux":

    def memory_bytes() -> int:
        """Return what of this process is in the computer's memory."""
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[_RESIDENT]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

elif sys.platform == "win32":

    def memory_bytes() -> int:
        """Return 0: the standard library cannot tell."""
        return 0

else:
    import resource

    def memory_bytes() -> int:
        """Return the most that this process ever had in the computer's memory."""
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


_KEPT_S: Final = 2.0
_PATIENCE_S: Final = 1.0  # with the database; health is asked for when something is wrong
_SILENT_S: Final = 10.0  # after which it counts as unreadable; a computer may be busy for a second
_OF_LATE_S: Final = 60.0


class HealthMonitor:
    """Finds the state of the service."""

    def __init__(
        self,
        database: Database,
        rack: DeviceRegistry,
        cell: Cell,
        backups: BackupSchedule | None,
        lines_lost: Callable[[], int],
    ) -> None:
        self._database = database
        self._rack = rack
        self._cell = cell
        self._backups = backups
        self._lines_lost = lines_lost
        self._turn = asyncio.Lock()
        self._found: tuple[float, State] | None = None
        self._offset_s = _offset_s()  # of the clock, when the service started
        self._counts = Counts({}, {}, {}, 0, 0, None)
        self._unanswered_since_s: float | None = None
        self._away = ""  # why the server of the database answers no query

    async def state(self) -> State:
        """Return the state of the service, two seconds old at most."""
        async with self._turn:
            now_s = time.monotonic()
            if self._found is None or now_s - self._found[0] > _KEPT_S:
                self._found = (now_s, await self._look())
            return self._found[1]

    async def _look(self) -> State:
        readable = await self._count()
        counts, cell, backups = self._counts, self._cell, self._backups
        return State(
            simulated=cell.simulated is not None,
            records=await self._records(readable),
            sessions=counts.sessions,
            jobs=counts.jobs,
            job_seconds=counts.job_seconds,
            devices={status.mounted.entry.name: _link(status) for status in self._rack.statuses()},
            clock=Clock(_offset_s() - self._offset_s, _ahead_s(counts.last_stamp)),
            certificates=days_left(cell, datetime.now().astimezone().date()),
            uncertified=without_end(cell),
            copies=None if backups is None else _copies(backups),
            memory_bytes=memory_bytes(),
            lines_lost=self._lines_lost(),
        )

    async def _count(self) -> bool:
        """Count the records; returns whether the database can be read, now or once its server is back."""
        try:
            async with asyncio.timeout(_PATIENCE_S):
                self._counts = await record_counts(self._database)
        except (ServerAwayError, ServerRefusedError) as error:
            self._away = str(error)
            return True
        except StorageError:
            return False
        except TimeoutError:
            return self._still_awaited() or self._is_silent_server()
        self._unanswered_since_s, self._away = None, ""
        return True

    def _is_silent_server(self) -> bool:
        """Return whether it is a server that does not answer, which is none of this service's faults."""
        held = self._database.backend
        if held.server_doubts is None:
            return False
        self._away = (
            f"The server of {held.where} has not answered for {_SILENT_S:.0f} s; see that it runs, and that "
            "the network leads to it."
        )
        return True

    def _still_awaited(self) -> bool:
        """Return whether the database has been silent for less than what a busy computer explains."""
        now_s = time.monotonic()
        if self._unanswered_since_s is None:
            self._unanswered_since_s = now_s
        return now_s - self._unanswered_since_s <= _SILENT_S

    async def _records(self, readable: bool) -> Records:
        database = self._database
        condition, file = database.condition, database.file
        return Records(
            readable=readable,
            late=self._unanswered_since_s is not None,
            refused=condition.trouble or self._away,
            reserve_used=database.backend.reserve_used,
            commit_s=await self._commit_s(),
            free_bytes=await asyncio.to_thread(free_bytes, file.parent),
            size_bytes=await asyncio.to_thread(database.backend.size_bytes),
            integrity=condition.integrity,
            checked_share=condition.verified_share,
            damage=condition.damage or "",
            unchecked=condition.unchecked or "",
            links=self._counts.links,
            readings=self._counts.readings,
            server_doubts=database.backend.server_doubts,
        )

    async def _commit_s(self) -> float | None:
        """Return how long commits take of late; where there was none, of one that is made for this."""
        commits = self._database.commits
        if commits.usual_s(_OF_LATE_S) is None:
            try:
                async with asyncio.timeout(_PATIENCE_S):
                    await self._database.write_a_trial()
            except (StorageError, TimeoutError):
                return None
        return commits.usual_s(_OF_LATE_S)


def _link(status: DeviceStatus) -> DeviceLink:
    return DeviceLink(status.connected, status.fault or "", status.is_foreign)


def _copies(backups: BackupSchedule) -> Copies:
    return Copies(backups.plan.every_s, backups.age_s, backups.fault or "")


def _offset_s() -> float:
    return time.time() - time.monotonic()


def _ahead_s(stamp: str | None) -> float | None:
    """Return how much later it is now than when the newest record was made."""
    if stamp is None:
        return None
    return (datetime.now(UTC) - datetime.fromisoformat(stamp)).total_seconds()
