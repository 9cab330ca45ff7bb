"""Turns: so many at once, some wait, and whoever comes then is sent away at once instead of piling up."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

from truepose.analysis.errors import BusyError


class Turns:
    """Lets `at_once` in, lets `waiting` wait for at most `patience_s`, and sends all others away."""

    def __init__(self, what: str, *, at_once: int, waiting: int, patience_s: float) -> None:
        self._what = what  # that everybody wants, in the plural: "uploads"
        self._most = at_once + waiting
        self._patience_s = patience_s
        self._places = asyncio.Semaphore(at_once)
        self._present = 0

    @contextlib.asynccontextmanager
    async def taken(self) -> AsyncIterator[None]:
        """Wait for a turn and hold it; raises BusyError."""
        if self._present >= self._most:
            raise BusyError(f"Too many {self._what} wait already; nothing was stored, ask again later.")
        self._present += 1
        try:
            async with contextlib.AsyncExitStack() as held:
                await self._wait(held)
                yield
        finally:
            self._present -= 1

    async def _wait(self, held: contextlib.AsyncExitStack) -> None:
        try:
            async with asyncio.timeout(self._patience_s):
                await held.enter_async_context(self._places)
        except TimeoutError as error:
            raise BusyError(
                f"Other {self._what} still have their turn; nothing was stored, ask again later."
            ) from error
