"""What only looks on while a session is under way: it may fail or hang, and the session goes on."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from typing import Final, TypeAlias

_LOG: Final = logging.getLogger(__name__)
Onlooker: TypeAlias = Callable[[], Awaitable[None]]  # called once the session runs, which may end before
_PATIENCE_S: Final = 5.0  # wall time, for an onlooker to leave when the session is over


@contextlib.asynccontextmanager
async def looked_on(onlookers: Sequence[Onlooker]) -> AsyncIterator[None]:
    """Let `onlookers` look on meanwhile; none of them ends what is looked at, or keeps it from ending."""
    tasks = [asyncio.create_task(_harmless(onlooker)) for onlooker in onlookers]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        if tasks and (await asyncio.wait(tasks, timeout=_PATIENCE_S))[1]:
            _LOG.warning("an onlooker did not leave within %g s and was left behind", _PATIENCE_S)


async def _harmless(onlooker: Onlooker) -> None:
    try:
        await onlooker()
    except Exception:
        _LOG.exception("looking on failed; the session goes on without it")
