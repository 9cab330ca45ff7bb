"""Looks after an open database: is it at its place, has somebody else written, is it as it was written.

The long look at everything is taken by a process of its own with the lowest priority, so that neither a start
nor a session waits for it. What it finds is looked at once more before it counts: a log that is begun anew
meanwhile can make a reader see what is not there.
"""

import asyncio
import contextlib
import json
import logging
import sys
from typing import Any, Final

from truepose.storage.database import Database
from truepose.storage.engine.backend import FOREIGN
from truepose.storage.errors import StorageError

_LOG: Final = logging.getLogger(__name__)
# A process and no thread: a thread shares the interpreter's lock with the session that measures, and cannot
# have a lower priority.
_COMMAND: Final = (sys.executable, "-m", "truepose.storage.integrity.verification")
_FIRST_S: Final = 2.0  # the service is ready before anything is looked through
_LOOK_S: Final = 1.0
_AGAIN_S: Final = 6 * 3600.0
_RETRY_S: Final = 600.0  # after a look that was not finished
_LINE_BYTES: Final = 1 << 20


class UnfinishedError(Exception):
    """The process that looks through the database ended before it had."""


class Guard:
    """Tells the condition of the database what it finds."""

    def __init__(self, database: Database, first_s: float = _FIRST_S) -> None:
        self._database = database
        self._condition = database.condition
        self._first_s = first_s
        self._doubt = asyncio.Event()  # somebody else has written

    async def follow(self) -> None:
        """Look until cancelled."""
        async with asyncio.TaskGroup() as together:
            together.create_task(self._keep_looking())
            together.create_task(self._keep_verifying())

    async def _keep_looking(self) -> None:
        while True:
            # Also while nothing is written: a database that was removed is brought back, and what another
            # program wrote is noticed within a second (decision 0061).
            if await self.look():
                self._doubt.set()
            with contextlib.suppress(StorageError):
                await self._database.keep_reserve()
            await asyncio.sleep(_LOOK_S)

    async def _keep_verifying(self) -> None:
        await asyncio.sleep(self._first_s)
        # Before the verification, since until it is done no log is taken over and the log grows.
        await self.check_seal()
        while True:
            # While the disk refuses, what lies at the place may be another file, and none of its records are
            # ours.
            await self._database.writable()
            # Before the look and not after it: whoever writes while everything is looked through is looked
            # through again.
            self._doubt.clear()
            again_s = _AGAIN_S
            try:
                await self._verify()
            except (OSError, UnfinishedError) as error:  # OSError: no process can be had now
                _LOG.warning("the database was not looked through: %s", error)
                self._condition.give_up_verification(str(error))
                again_s = _RETRY_S
            # not wait_for: before Python 3.12 it drops a cancellation that comes together with the doubt
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(again_s):
                    await self._doubt.wait()

    async def check_seal(self) -> None:
        """Compare the database with how it was left; until then nothing is taken over from a log into it."""
        backend = self._database.backend
        said = await asyncio.to_thread(backend.changed_since_left)
        if said is not None:
            self._condition.note_damage("seal", said)
        with contextlib.suppress(StorageError):
            await self._database.on_writer(lambda _plain: backend.resume())

    async def look(self) -> bool:
        """See that the file is at its place; returns whether somebody else has written to it."""
        # A database that is away cannot be looked at; the trial brings it back first.
        if self._condition.trouble is not None:
            return False
        try:
            seen = await self._database.on_writer(lambda _plain: self._database.backend.look())
        except StorageError:
            return False
        if seen.foreign:
            self._condition.note_damage(
                FOREIGN,
                f"Another program has written to {self._database.backend.where}; "
                "every record is being checked.",
            )
        for finding in seen.missing:
            self._condition.note_damage(finding, finding)
        return seen.foreign

    async def _verify(self) -> None:
        self._condition.begin_verification()
        findings = await self._findings()
        if findings:
            # Read once more before it counts: a reader may see a log that is just begun anew together with
            # pages of before.
            findings = await self._findings()
        # The process opens the file by its name. Where another one lies there by now, what was found is of
        # that.
        if findings and not await self._is_ours():
            self._doubt.set()  # once it is, it is looked through
            return
        for finding in findings:
            _LOG.error("%s", finding)
            self._condition.note_damage(finding, finding)
        self._condition.end_verification(whole=not findings)

    async def _is_ours(self) -> bool:
        """Whether what lies at the place is the open database, which alone can be damaged."""
        await self.look()
        return self._condition.trouble is None

    async def _findings(self) -> list[str]:
        process = await asyncio.create_subprocess_exec(
            *_COMMAND,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            limit=_LINE_BYTES,
        )
        try:
            return await self._heard(process)
        finally:
            if process.returncode is None:
                process.kill()
            await process.wait()

    async def _heard(self, process: asyncio.subprocess.Process) -> list[str]:
        told: dict[str, Any] = {}
        if process.stdin is not None and process.stdout is not None:
            # The URL may hold a password, and arguments are seen by everybody on the machine.
            process.stdin.write(f"{self._database.backend.url}\n".encode())
            process.stdin.close()
            async for line in process.stdout:
                told = _told(line)
                self._condition.verified_share = told["share"]
        # A process that was killed, or could not read the database, has found nothing and says so of nothing:
        # only the last line, and an end in order, say that every record was read.
        if await process.wait() != 0 or "records" not in told:
            raise UnfinishedError(f"the process that reads it ended with status {process.returncode}")
        findings: list[str] = told["findings"]
        return findings


def _told(line: bytes) -> dict[str, Any]:
    """Return a line of the process; raises UnfinishedError for one that it cannot have written."""
    with contextlib.suppress(ValueError):
        told = json.loads(line)
        if isinstance(told, dict) and "share" in told:
            return told
    raise UnfinishedError(f"the process that reads it reported {line[:100]!r}")
