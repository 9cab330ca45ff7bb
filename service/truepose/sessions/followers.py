"""Which tablets follow which session, and the news that wake them."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Iterator
from typing import Any

from truepose.sessions.engine.runner import SessionRunner


class TabletCounter:
    """Counts tablets, each over as many connections as it likes."""

    def __init__(self) -> None:
        self._connections: dict[int, Counter[str]] = {}
        self._news = asyncio.Event()

    @property
    def news(self) -> asyncio.Event:
        """What the next news set; take it before looking, so that none falls between."""
        return self._news

    def tell(self) -> None:
        """Wake everybody who waits for news."""
        self._news.set()
        self._news = asyncio.Event()

    def count(self, session_id: int) -> int:
        """Return how many tablets follow a session."""
        # A unary plus leaves out tablets whose connections have all gone.
        return len(+self._connections.get(session_id, Counter()))

    @contextlib.contextmanager
    def by(self, session_id: int, tablet: str) -> Iterator[None]:
        """Count a tablet among those that follow a session."""
        # A tablet that loads its page anew has two connections for a moment, and is still one.
        connections = self._connections.setdefault(session_id, Counter())
        connections[tablet] += 1
        self.tell()
        try:
            yield
        finally:
            connections[tablet] -= 1
            self.tell()


async def change(news: asyncio.Event, runner: SessionRunner[Any] | None, version: int | None) -> None:
    """Return once there are news, or what is under way is no longer at this version."""
    waits: list[asyncio.Future[Any]] = [asyncio.ensure_future(news.wait())]
    if runner is not None and version is not None:
        waits.append(asyncio.ensure_future(runner.changed(version)))
    try:
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for wait in waits:
            wait.cancel()
