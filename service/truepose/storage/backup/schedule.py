"""Copies on a schedule: made while the service runs, so many of them kept."""

import asyncio
import logging
import re
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from truepose.storage.backup.addressed import back_up_at
from truepose.storage.backup.drafts import drafts_beside
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.errors import StorageError
from truepose.storage.files.owner_alone import tighten

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

    @property
    def age_s(self) -> float | None:
        """Return how old the newest copy is; None where there is none."""
        copies = copies_in(self.plan.folder)
        return max(0.0, self._now_s() - copies[-1][0]) if copies else None

    async def follow(self) -> None:
        """Make copies until cancelled."""
        await asyncio.sleep(_FIRST_S)
        tighten(*(file for _, file in copies_in(self.plan.folder)))
        while True:
            await asyncio.sleep(await self.make_if_due())

    async def make_if_due(self) -> float:
        """Make a copy where the newest one is old enough; returns after how long to look again [s]."""
        age_s = self.age_s
        if age_s is not None and age_s < self.plan.every_s:
            return self.plan.every_s - age_s
        try:
            await asyncio.to_thread(self._make)
        except (StorageError, OSError) as error:
            _LOG.error("no copy of the database was made: %s", error)
            self.fault = str(error)
            return min(_AGAIN_S, self.plan.every_s)
        self.fault = None
        return self.plan.every_s

    def _make(self) -> None:
        stamp = datetime.fromtimestamp(self._now_s(), UTC).strftime(_STAMP)
        made = back_up_at(self._url, self.plan.folder / f"truepose-{stamp}.sqlite3")
        _LOG.info("%s: a copy of %d records, verified", made.file, made.head.links)
        for _, file in copies_in(self.plan.folder)[: -self.plan.keep]:
            file.unlink(missing_ok=True)
            drafts_beside(file).unlink(missing_ok=True)
            _LOG.info("%s: an older copy than the %d that are kept was removed", file, self.plan.keep)


def copies_in(folder: Path) -> list[tuple[float, Path]]:
    """Return the copies of a schedule with the moment when each was begun, oldest first."""
    if not folder.is_dir():
        return []
    named = [(_NAME.fullmatch(file.name), file) for file in folder.iterdir()]
    return sorted((_moment_s(name[1]), file) for name, file in named if name)


def _moment_s(stamp: str) -> float:
    return datetime.strptime(stamp, _STAMP).replace(tzinfo=UTC).timestamp()
