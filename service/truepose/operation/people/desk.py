"""Everything about who asks, opened with the database and closed before it."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

from truepose.operation.people.accounts import Accounts
from truepose.operation.people.act_log import ActLog
from truepose.operation.people.guesses import Guesses
from truepose.operation.people.leases import Leases
from truepose.operation.people.register import Register
from truepose.storage.database import Database
from truepose.storage.people.acts import ActRepository
from truepose.storage.people.credentials import CredentialRepository


@dataclass(frozen=True, slots=True)
class PeopleDesk:
    """Who is entered, who acts where, and what they did."""

    accounts: Accounts
    leases: Leases
    acts: ActRepository
    log: ActLog
    refusals: Guesses  # how many of an address are put on record


@contextlib.asynccontextmanager
async def open_people(database: Database, *, asked_for: bool, alone: bool) -> AsyncIterator[PeopleDesk]:
    """Open the desk; what was noted is on disk when it closes."""
    register = Register(CredentialRepository(database))
    await register.load()
    acts = ActRepository(database)
    log = ActLog(acts, database.writable)
    elapsed_s = register.time.elapsed_s
    accounts = Accounts(register, asked_for=asked_for, alone=alone)
    following = asyncio.create_task(log.follow(), name="acts")
    try:
        yield PeopleDesk(accounts, Leases(elapsed_s), acts, log, Guesses(elapsed_s))
    finally:
        log.end()
        await following
