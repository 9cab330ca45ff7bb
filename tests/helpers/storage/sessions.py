"""Sessions in a database, and the guard that a service has over it."""

import asyncio
import contextlib

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.helpers.machine import HANGS_S
from truepose.storage.integrity.monitor import Guard
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import Page


async def add(database, name="first"):
    """Add a session; return its number."""
    return await SessionRepository(database).add(name, make_setup(), make_plan())


async def names(database):
    """Return the names of the sessions, the first one first."""
    return [record.name for record in await SessionRepository(database).page(Page())]


async def measure(database, session, count):
    """Have so many points measured in a session."""
    ledger = LedgerRepository(database)
    for config in range(1, count + 1):
        await ledger.append(session, point_taken(make_point(config)))


async def fill(database):
    """Add two sessions, the first one with five readings."""
    first = await add(database, "first")
    await add(database, "second")
    await measure(database, first, 5)


async def wait_until(condition):
    """Wait until something holds."""
    async with asyncio.timeout(HANGS_S):
        while not condition():
            await asyncio.sleep(0.02)


@contextlib.asynccontextmanager
async def guarded(database, *, found_whole=True):
    """Let a guard look after a database, by default once it has found every record whole."""
    guarding = asyncio.create_task(Guard(database, 0.0).follow())
    if found_whole:
        await wait_until(lambda: database.condition.integrity == "whole")
    try:
        yield guarding
    finally:
        guarding.cancel()
        await asyncio.gather(guarding, return_exceptions=True)
