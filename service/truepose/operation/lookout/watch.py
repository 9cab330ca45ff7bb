"""Looks at the service for whoever asks, not more often than every two seconds."""

import asyncio
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Final

from truepose.domain.cell.description import Cell
from truepose.operation.devices import DeviceStatus, Rack
from truepose.operation.lookout.certificates import days_left, without_end
from truepose.operation.lookout.computer import free_bytes, memory_bytes
from truepose.operation.lookout.state import Clock, Copies, DeviceLink, Records, State
from truepose.storage.backup.schedule import BackupSchedule
from truepose.storage.counts import Counts, counted
from truepose.storage.database import Database
from truepose.storage.errors import ServerAwayError, ServerRefusedError, StorageError

_KEPT_S: Final = 2.0
_PATIENCE_S: Final = 1.0  # with the database; health is asked for when something is wrong
_SILENT_S: Final = 10.0  # after which it counts as unreadable; a computer may be busy for a second
_OF_LATE_S: Final = 60.0


class Lookout:
    """Finds the state of the service."""

    def __init__(
        self,
        database: Database,
        rack: Rack,
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
                self._counts = await counted(self._database)
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
        held = self._database.held
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
            reserve_used=database.held.reserve_used,
            commit_s=await self._commit_s(),
            free_bytes=await asyncio.to_thread(free_bytes, file.parent),
            size_bytes=await asyncio.to_thread(database.held.size_bytes),
            integrity=condition.integrity,
            checked_share=condition.verified_share,
            damage=condition.damage or "",
            links=self._counts.links,
            readings=self._counts.readings,
            server_doubts=database.held.server_doubts,
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
