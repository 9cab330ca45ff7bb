"""Whether workers that somebody named can be asked, known to whoever does not want to wait for them."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Final

from truepose.analysis.cluster.named import named

_AGAIN_S: Final = 30.0  # between two looks, and after a failure
_PATIENCE_S: Final = 1.0  # for a scheduler to take a connection


class Reach:
    """How workers stood when somebody looked last; a look takes a second at most.

    Raises ConfigurationError where `where` names none.
    """

    def __init__(self, where: str, now_s: Callable[[], float] = time.monotonic) -> None:
        self._scheduler = named(where)
        self._now_s = now_s
        self._fault = ""
        self._seen_s = -_AGAIN_S

    async def fault(self) -> str:
        """Return in a sentence why they cannot be asked, empty where they can."""
        if self._now_s() - self._seen_s >= _AGAIN_S:
            self.seen(await self._looked())
        return self._fault

    def seen(self, fault: str) -> None:
        """Take what somebody met who asked them."""
        self._fault, self._seen_s = fault, self._now_s()

    async def _looked(self) -> str:
        if not self._scheduler.scheduler:
            return ""  # of this computer
        host, port = self._scheduler.host_and_port
        try:
            async with asyncio.timeout(_PATIENCE_S):
                _, writer = await asyncio.open_connection(host, port)
        except OSError:
            return f"No Dask scheduler answers at {self._scheduler.scheduler}."
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
        return ""
