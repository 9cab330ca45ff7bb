"""Programs as somebody types them: commands that end, and services that run until they are ended."""

import asyncio
import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, Final, TypeVar

T = TypeVar("T")
_TRUEPOSE: Final = (sys.executable, "-m", "truepose")
_START_S: Final = 90.0
_PATIENCE_S: Final = 120.0
_ASK_S: Final = 0.1


async def truepose(*words: str | Path, status: int = 0) -> str:
    """Run a command to its end and return what it printed; a status that is not expected fails the day."""
    process = await asyncio.create_subprocess_exec(
        *_TRUEPOSE,
        *(str(word) for word in words),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    printed, remarks = await process.communicate()
    command = " ".join(str(word) for word in words)
    assert process.returncode == status, f"truepose {command}: {process.returncode}, {remarks.decode()}"
    return printed.decode()


async def answered(*words: str | Path, status: int = 0) -> dict[str, Any]:
    """Run a command with `--json` and return what it printed."""
    found: dict[str, Any] = json.loads(await truepose(*words, "--json", status=status))
    return found


class Running:
    """A program that runs until it is ended; its group goes with it."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    @classmethod
    async def begin(cls, command: tuple[str, ...], log: Path, folder: Path) -> "Running":
        """Start a program."""
        with log.open("ab") as errors:
            process = await asyncio.create_subprocess_exec(
                *command,
                stdout=asyncio.subprocess.PIPE,
                stderr=errors,
                cwd=folder,
                start_new_session=True,
            )
        return cls(process)

    @classmethod
    async def serving(cls, *words: str, log: Path, folder: Path) -> tuple["Running", dict[str, str]]:
        """Start a service of truepose, and return what it says when it is ready."""
        running = await cls.begin((*_TRUEPOSE, *words), log, folder)
        assert running._process.stdout is not None
        line = await asyncio.wait_for(running._process.stdout.readline(), _START_S)
        assert line, f"truepose {words[0]} did not start; see {log}"
        ready: dict[str, str] = json.loads(line)
        return running, ready

    async def ask_to_end(self) -> None:
        """End it as a service manager does."""
        await self._end(signal.SIGTERM)

    async def kill(self) -> None:
        """End it as a power cut would."""
        await self._end(signal.SIGKILL)

    async def _end(self, by: signal.Signals) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, by)
        await self._process.wait()


async def until(look: Callable[[], Awaitable[T | None]], what: str) -> T:
    """Look again and again until there is something to see."""
    deadline_s = time.monotonic() + _PATIENCE_S
    while (found := await look()) is None:
        assert time.monotonic() < deadline_s, f"this did not come within {_PATIENCE_S:.0f} s: {what}"
        await asyncio.sleep(_ASK_S)
    return found
