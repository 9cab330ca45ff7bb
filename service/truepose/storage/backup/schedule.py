"""Copies as the service and its commands make them: by address, on a schedule, and which files may go.

A copy is always a file, of a server's database one with all its records. Readings, acts, results and the
uploads that they came from are records: they are in the chain, and stay. Live values are never stored. What
is left are old logs, surplus copies, and what an interrupted copy left behind.
"""

import asyncio
import contextlib
import logging
import math
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from truepose.messages.message import Text
from truepose.storage.backup.copying import Backup, Told, back_up, drafts_beside, require_copy, write_copy
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.backup.restoring import restore, whole_copy
from truepose.storage.backup.transfer import fill, transfer
from truepose.storage.engine.address import database_file, is_server, parsed_url
from truepose.storage.engine.files import sync_file, tighten
from truepose.storage.engine.reading import lies_beside
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import BackupError, StorageError
from truepose.storage.integrity.head_hash import Head


def back_up_at(
    url: str, target: Path, told: Told = lambda share, doing: None, *, replace: bool = False
) -> Backup:
    """Copy a database into one file, while a service runs or not; raises StorageError."""
    if not is_server(parsed_url(url)):
        return back_up(database_file(url), target, told, replace=replace)

    def write(part: Path, told: Told) -> Head:
        # A copy of a server is a file as well: it is verified, and read again in years, without a server of
        # the same version (decision 0061).
        head = fill(url, f"sqlite:///{part}", told)
        _make_one_file(part)
        require_copy(part, head)
        return head

    return write_copy(lies_beside(url), target, write, told, replace=replace)


def restore_at(
    copy: Path, url: str, told: Told = lambda share, doing: None, *, replace: bool = False
) -> tuple[Head, Path | None]:
    """Put a copy in the place of a database; of a server's only into an empty one. Raises StorageError."""
    if not is_server(parsed_url(url)):
        return restore(copy, database_file(url), told, replace=replace)
    if replace:
        raise BackupError(
            "A database on a server is not moved aside: restore into an empty database there and keep the"
            " old one."
        )
    whole_copy(copy, told)
    return transfer(f"sqlite:///{copy.resolve()}", url, told)[0], None


def _make_one_file(part: Path) -> None:
    """Leave a database that was just written as one file, which is on the disk."""
    with contextlib.closing(LIBRARY.connect(part)) as copy:
        copy.execute("PRAGMA journal_mode=DELETE")
    sync_file(part)


_LOG: Final = logging.getLogger(__name__)
_NAME: Final = re.compile(r"truepose-(\d{8}T\d{6}Z)\.sqlite3")
_STAMP: Final = "%Y%m%dT%H%M%SZ"
_FIRST_S: Final = 5.0  # a service that is just starting has other things to do
_AGAIN_S: Final = 600.0  # after a copy that failed


class BackupSchedule:
    """Makes the copies of a plan, and says how old the newest one is."""

    def __init__(self, url: str, plan: BackupPlan, now_s: Callable[[], float] = time.time) -> None:
        self.plan = plan
        self.fault: str | None = None  # of the last attempt
        self._url = url
        self._now_s = now_s
        self._ended = False

    @property
    def age_s(self) -> float | None:
        """Return how old the newest copy is; None where there is none, or the folder cannot be read."""
        with contextlib.suppress(OSError):
            return self._newest_age_s()
        return None

    async def follow(self) -> None:
        """Make copies until cancelled."""
        await asyncio.sleep(_FIRST_S)
        # What cannot be read now is said when a copy is due.
        with contextlib.suppress(OSError):
            # Copies that an earlier version made may be readable by everybody (commit 5c314de7).
            tighten(*(file for _, file in copies_in(self.plan.folder)))
        while True:
            await asyncio.sleep(await self.make_if_due())

    async def make_if_due(self) -> float:
        """Make a copy where the newest one is old enough; returns after how long to look again [s]."""
        # The newest copy says when the next one is due, and no clock of this process: a service that is
        # restarted every day would otherwise never make one, or one at each start.
        try:
            age_s = self._newest_age_s()
            if age_s is None or age_s >= self.plan.every_s:
                await self._make_off_the_loop()
                age_s = 0.0
        except (StorageError, OSError) as error:
            _LOG.error("the copy of the database failed: %s", error)
            self.fault = str(error)
            return min(_AGAIN_S, self.plan.every_s)
        self.fault = None
        return self.plan.every_s - age_s

    def _newest_age_s(self) -> float | None:
        now_s = self._now_s()
        copies = copies_in(self.plan.folder, now_s)
        return now_s - copies[-1][0] if copies else None

    async def _make_off_the_loop(self) -> None:
        # Copying takes seconds to minutes of reading, which the loop of a session that measures has not.
        making = asyncio.ensure_future(asyncio.to_thread(self._make))
        try:
            await asyncio.shield(making)
        except asyncio.CancelledError:
            # The thread goes on, and the service lets the database go once this task has ended: closing its
            # file would drop the locks under which the thread reads.
            self._ended = True
            await asyncio.gather(making, return_exceptions=True)
            raise

    def _require_going_on(self, _share: float, _doing: Text) -> None:
        if self._ended:
            raise BackupError("The service is shutting down; no copy was made.")

    def _make(self) -> None:
        now_s = self._now_s()
        stamp = datetime.fromtimestamp(now_s, UTC).strftime(_STAMP)
        target = self.plan.folder / f"truepose-{stamp}.sqlite3"
        made = back_up_at(self._url, target, self._require_going_on)
        _LOG.info("%s: a copy of %d records, verified", made.file, made.head.links)
        # Only after a copy was made and verified: one that fails never costs an older one.
        for _, file in copies_in(self.plan.folder, now_s)[: -self.plan.keep]:
            file.unlink(missing_ok=True)
            drafts_beside(file).unlink(missing_ok=True)
            _LOG.info("%s: an older copy than the %d that are kept was removed", file, self.plan.keep)


def copies_in(folder: Path, until_s: float = math.inf) -> list[tuple[float, Path]]:
    """Return the copies of a schedule with the moment when each was begun, oldest first; raises OSError.

    Those of after `until_s` are left out. Where the clock was ahead once, such a copy would be the newest one
    for years: no other would be made, and those that were would go first.
    """
    if not folder.is_dir():
        return []
    # By name, not by time stamp of the file: whoever copies the folder to another disk changes the latter.
    # Files of other names are somebody else's, and stay.
    named = [(_moment_s(file.name), file) for file in folder.iterdir()]
    return sorted((begun_s, file) for begun_s, file in named if begun_s is not None and begun_s <= until_s)


def _moment_s(name: str) -> float | None:
    found = _NAME.fullmatch(name)
    with contextlib.suppress(ValueError):  # digits that are no moment
        return found and datetime.strptime(found[1], _STAMP).replace(tzinfo=UTC).timestamp()
    return None


_DAY_S: Final = 86400.0
_LEFT_BEHIND: Final = (".rescued", ".restored", ".to-restore.part")  # beside the database
_PART: Final = re.compile(rf"{_NAME.pattern}(\.drafts\.zip)?\.part([.-]\w+)?")  # among its copies
_SURELY_LEFT_S: Final = _DAY_S  # no copy takes so long


@dataclass(frozen=True, slots=True)
class Rules:
    """How long what may go is kept."""

    logs_days: float = 90.0
    copies: Path | None = None  # folder of the copies on a schedule
    keep_copies: int = 7


@dataclass(frozen=True, slots=True)
class SurplusCopy:
    """A file that may go, and why."""

    file: Path
    size_bytes: int
    why: str


def surplus(database: Path, rules: Rules, now_s: Callable[[], float] = time.time) -> list[SurplusCopy]:
    """Return the files that may go, beside a database and among its copies."""
    found = [*_old_logs(database, rules, now_s()), *_left_behind(database, rules.copies, now_s())]
    if rules.copies is not None:
        found += _surplus_copies(rules.copies, rules.keep_copies, now_s())
    return [SurplusCopy(file, file.stat().st_size, why) for file, why in found]


def drop(found: list[SurplusCopy]) -> None:
    """Remove files that may go."""
    for one in found:
        one.file.unlink(missing_ok=True)


def _old_logs(database: Path, rules: Rules, now_s: float) -> Iterator[tuple[Path, str]]:
    # Only logs that were turned over; the present one is without a number.
    for file in sorted(database.parent.glob(f"{database.name}.log.*")):
        days = (now_s - file.stat().st_mtime) / _DAY_S
        if days > rules.logs_days:
            yield file, f"log, {days:.0f} days old"


def _left_behind(database: Path, copies: Path | None, now_s: float) -> Iterator[tuple[Path, str]]:
    files = [database.with_name(f"{database.name}{ending}") for ending in _LEFT_BEHIND]
    if copies is not None and copies.is_dir():
        files += sorted(file for file in copies.iterdir() if _PART.fullmatch(file.name))
    for file in files:
        if file.exists() and now_s - file.stat().st_mtime > _SURELY_LEFT_S:
            yield file, "left by an interrupted copy"


def _surplus_copies(folder: Path, keep: int, now_s: float) -> Iterator[tuple[Path, str]]:
    for _, file in copies_in(folder, now_s)[:-keep]:
        yield file, f"copy, older than the newest {keep}"
        if drafts_beside(file).exists():
            yield drafts_beside(file), "drafts of such a copy"
