"""Everything about who asks, opened with the database and closed before it."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Final

from truepose.domain.errors import RecordRefusedError
from truepose.operation.people.accounts import Accounts
from truepose.operation.people.act_log import ActLog
from truepose.operation.people.guesses import Guesses
from truepose.operation.people.leases import Leases
from truepose.operation.people.pins import Pins
from truepose.operation.people.register import Register
from truepose.storage.database import Database
from truepose.storage.people.acts import ActRepository
from truepose.storage.people.credentials import CredentialKind, CredentialRepository

_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PeopleDesk:
    """Who is entered, who acts where, and what they did."""

    accounts: Accounts
    leases: Leases
    acts: ActRepository
    log: ActLog
    refusals: Guesses  # how many of an address are put on record


@contextlib.asynccontextmanager
async def open_people(
    database: Database, pins: Pins, *, asked_for: bool, alone: bool
) -> AsyncIterator[PeopleDesk]:
    """Open the desk; what was noted is on disk when it closes."""
    stored = CredentialRepository(database)
    register = Register(stored)
    await register.load()
    with contextlib.suppress(RecordRefusedError):  # the next start tries again
        await stored.take_out_revoked()
    acts = ActRepository(database)
    log = ActLog(acts, database.writable)
    elapsed_s = register.time.elapsed_s
    accounts = Accounts(register, pins, asked_for=asked_for, alone=alone)
    _warn_of_pins(accounts)
    following = asyncio.create_task(log.follow(), name="acts")
    try:
        yield PeopleDesk(accounts, Leases(elapsed_s), acts, log, Guesses(elapsed_s))
    finally:
        log.end()
        await following


def _warn_of_pins(accounts: Accounts) -> None:
    """Say whose PINs count no more: the database was restored, or came here from another machine."""
    kept = [r for r in accounts.register.credentials if r.kind is CredentialKind.PIN]
    gone = sum(not accounts.pins.counts(record.hash) for record in kept)
    if gone:
        _LOG.warning(
            "%d PINs do not count here, as the database was restored or moved: a copy holds none. Passwords "
            "do; each person chooses a PIN anew at /account.",
            gone,
        )
