"""Accounts: who is entered, how they come in, and whether anybody is asked at all.

A service on this computer alone is open until somebody is entered; from then on everybody signs in. One that
others reach is closed from its first start: only the link that it prints lets the first person in.
"""

import asyncio
import contextlib
import hmac
import logging
import re
from collections.abc import AsyncIterator, Collection
from dataclasses import dataclass
from typing import Any, Final

from truepose.domain.people import MACHINE, OF_PROGRAMS, Person, Role, lesser, reaches
from truepose.messages.message import message
from truepose.people.act_log import PATIENCE_S, ActLog
from truepose.people.attempts import Attempts, Guesses
from truepose.people.errors import AccountRefusedError, SignInRefusedError
from truepose.people.leases import Leases
from truepose.people.register import EVERYBODY, LINK_IS_OVER, NOBODY, OF_MACHINE, Caller, Register
from truepose.people.secrets import Badges, Pins, SlowHashes, chosen_hash, fingerprint, new_secret
from truepose.people.sign_ins import SignedIn, SignIns
from truepose.storage.database import Database
from truepose.storage.people import (
    ActRepository,
    CredentialKind,
    CredentialRecord,
    CredentialRepository,
    NewCredential,
)

SHORTEST_PASSWORD: Final = 10
LONGEST_SECRET: Final = 200
LINK_DAYS: Final = 3
_PIN: Final = re.compile(r"[0-9]{4,12}")
# Of a program's token: it may do what its owner may, and a plant asks for what is an administrator's.
_LEAST_OWNER: Final = {Role.DEVICE: Role.VIEWER, Role.PLANT: Role.ADMINISTRATOR}


@dataclass(frozen=True, slots=True)
class Preferences:
    """What somebody chose for themselves; None: stays as it is."""

    password: str | None = None
    pin: str | None = None
    badge: str | None = None


class Accounts:
    """Everything about who asks."""

    def __init__(self, register: Register, pins: Pins, *, asked_for: bool = True, alone: bool = True) -> None:
        """Work with a register that is loaded.

        Parameters
        ----------
        register : Register
        pins : Pins
        asked_for : bool
            Whether anybody is ever asked who they are.
        alone : bool
            Whether only this computer reaches the service.
        """
        self.register = register
        self.attempts = Attempts(register)
        self.pins = pins
        self._hashes = SlowHashes()
        self._badges = Badges(r.hash for r in register.credentials if r.kind is CredentialKind.BADGE)
        self.sign_ins = SignIns(register, self.attempts, pins, self._badges, self._hashes)
        self._asked_for = asked_for
        self._alone = alone
        self.first_secret = new_secret()
        self.machine_secret = new_secret()  # for commands of this machine, as long as the service runs

    @property
    def nobody_entered(self) -> bool:
        """Whether the first person is still to come."""
        return not self.register.people

    @property
    def asked_for(self) -> bool:
        """Whether the service asks who somebody is, now or once the first person is entered."""
        return self._asked_for

    @property
    def are_open(self) -> bool:
        """Whether nobody is asked who they are."""
        return not self._asked_for or (self._alone and self.nobody_entered)

    def caller_of(self, cookie: str | None, token: str | None) -> Caller:
        """Return who asks; NOBODY where a secret opens nothing, or where cookie and token come together."""
        # Looked at before the service may be open: while nobody is entered this command alone enters the
        # first person, which whoever else asks may not.
        if token is not None and hmac.compare_digest(token.encode(), self.machine_secret.encode()):
            return OF_MACHINE if cookie is None else NOBODY
        if self.are_open:
            return EVERYBODY
        if token is not None:
            return NOBODY if cookie is not None else self._program(token)
        return NOBODY if cookie is None else self.sign_ins.caller_of(cookie)

    def lasts(self, caller: Caller) -> bool:
        """Whether somebody who was let in is so still: for what is sent over hours."""
        if caller.everybody:
            return self.are_open
        if caller.sign_in is not None:
            return self.sign_ins.lasts(caller)
        return caller.token is None or self.register.credential(caller.token) is not None

    def opens_first(self, secret: str) -> bool:
        """Whether a secret lets the first person in."""
        right = hmac.compare_digest(secret.encode(), self.first_secret.encode())
        return right and self.nobody_entered and self._asked_for

    async def enter_first(self, secret: str, name: str, chosen: Preferences, address: str) -> SignedIn:
        """Enter the first person, as administrator; raises SignInRefusedError, AccountRefusedError."""
        with self.attempts.by_link(address):
            if not self.opens_first(secret):
                raise SignInRefusedError(LINK_IS_OVER)
        if chosen.password is None:
            raise AccountRefusedError(message("people.first_password"))
        # With the password in one go: somebody who is entered and has none could not come in any more.
        person = await self.register.enter_first(name, *await self._kept(None, chosen))
        return await self.sign_ins.opened(person, "", address)

    async def enter(self, name: str, role: Role, by: str) -> tuple[Person, str]:
        """Enter somebody; return them and the secret of the link with which they choose a password."""
        if self.nobody_entered:
            # From the first person on everybody signs in. They come by the printed link alone, so that no
            # program closes a service by trying (decision 0057).
            raise AccountRefusedError(message("people.first_first"))
        return await self._entered(name, role, by)

    async def enter_by_machine(self, name: str, role: Role) -> tuple[Person, str]:
        """Enter somebody from the machine's own command line, the first person too; as `enter`."""
        if self.nobody_entered and role is not Role.ADMINISTRATOR:
            raise AccountRefusedError(message("people.first_administrator"))
        return await self._entered(name, role, MACHINE)

    async def _entered(self, name: str, role: Role, by: str) -> tuple[Person, str]:
        secret, link = self._made(CredentialKind.LINK, None, LINK_DAYS, {"by": by})
        return await self.register.enter(name, role, by, link), secret

    async def link(self, person: Person, by: str) -> str:
        """Return the secret of a link that lets somebody choose a password, once."""
        secret, link = self._made(CredentialKind.LINK, person, LINK_DAYS, {"by": by})
        await self.register.put(person, [link], by=by)
        return secret

    def _made(
        self, kind: CredentialKind, person: Person | None, days: float, document: dict[str, Any]
    ) -> tuple[str, NewCredential]:
        """Return a random secret, and what is kept of it for so many days."""
        secret, until = new_secret(), self.register.time.in_future(days)
        number = None if person is None else person.id
        return secret, NewCredential(kind, number, fingerprint(secret), until, document)

    def invited(self, secret: str) -> Person | None:
        """Return whom a link is for; None where it was used or has expired."""
        record = self.register.opened_by(CredentialKind.LINK, fingerprint(secret))
        return None if record is None else self.register.person(record.person_id)

    async def accept(self, secret: str, chosen: Preferences, address: str) -> SignedIn:
        """Let somebody choose a password by their link; raises SignInRefusedError, AccountRefusedError."""
        with self.attempts.by_link(address):
            record = self.register.opened_by(CredentialKind.LINK, fingerprint(secret))
            person = None if record is None else self.register.person(record.person_id)
            if record is None or person is None:
                raise SignInRefusedError(LINK_IS_OVER)
        if chosen.password is None:
            raise AccountRefusedError(message("people.choose_password"))
        kept = await self.choose(person, chosen, resting_on=[record.id])
        return await self.sign_ins.opened(person, "", address, resting_on=kept)

    async def choose(
        self, person: Person, chosen: Preferences, *, resting_on: Collection[int] = ()
    ) -> list[int]:
        """Keep what somebody chose, and return its numbers.

        A new password closes every tablet they had opened, and every link to choose one. Raises
        SignInRefusedError where what it rests on was taken back meanwhile, and AccountRefusedError.
        """
        new = await self._kept(person, chosen)
        ends = () if chosen.password is None else (CredentialKind.SIGN_IN, CredentialKind.LINK)
        kept = await self.register.put(person, new, ends=ends, resting_on=resting_on, by=person.name)
        return [record.id for record in kept]

    async def _kept(self, person: Person | None, chosen: Preferences) -> list[NewCredential]:
        """Return what is to be kept of what somebody chose; raises AccountRefusedError."""
        _require_usable(chosen)
        hashes = {
            CredentialKind.PASSWORD: (chosen_hash, chosen.password),
            CredentialKind.PIN: (self.pins.kept, chosen.pin),
            CredentialKind.BADGE: (self._badges.hashed, chosen.badge),
        }
        number = None if person is None else person.id
        return [
            NewCredential(kind, number, await self._hashes.of(hashed, secret))
            for kind, (hashed, secret) in hashes.items()
            if secret is not None
        ]

    def has_pin(self, person: Person) -> bool:
        """Whether somebody has a PIN that counts here."""
        return any(self.pins.counts(r.hash) for r in self.register.of(person.id, CredentialKind.PIN))

    async def make_token(
        self, person: Person, name: str, role: Role, days: float, by: str
    ) -> tuple[CredentialRecord, str]:
        """Return a token for a program, and its secret, which is shown once."""
        if not reaches(person.role, _LEAST_OWNER.get(role, role)):
            raise AccountRefusedError(
                message("people.token_role", person=person.name, role=person.role.value)
            )
        document = {"name": name, "role": role.value, "by": by}
        secret, kept = self._made(CredentialKind.TOKEN, person, days, document)
        return await self.register.keep(kept), secret

    async def make_watch_link(self, session_id: int, days: float, by: Caller) -> tuple[CredentialRecord, str]:
        """Return what lets whoever has it look at one session, and its secret, which is shown once."""
        document = {"session_id": session_id, "by": by.name}
        secret, kept = self._made(CredentialKind.WATCH, by.person, days, document)
        return await self.register.keep(kept), secret

    def watched_by(self, secret: str) -> CredentialRecord | None:
        """Return the watch link of a secret; None where it opens nothing any more."""
        return self.register.opened_by(CredentialKind.WATCH, fingerprint(secret))

    def _program(self, secret: str) -> Caller:
        record = self.register.opened_by(CredentialKind.TOKEN, fingerprint(secret))
        person = None if record is None else self.register.person(record.person_id)
        if record is None or person is None:
            return NOBODY
        role = lesser(Role(record.document["role"]), person.role)
        name = record.document["name"] if role in OF_PROGRAMS else person.name
        return Caller(name, role, person, tablet_name=record.document["name"], token=record.id)


def _require_usable(chosen: Preferences) -> None:
    """Raise AccountRefusedError for what is too easily guessed."""
    if chosen.password is not None and len(chosen.password) < SHORTEST_PASSWORD:
        raise AccountRefusedError(message("people.password_length", characters=SHORTEST_PASSWORD))
    if chosen.pin is not None and (_PIN.fullmatch(chosen.pin) is None or len(set(chosen.pin)) == 1):
        raise AccountRefusedError(message("people.pin_digits"))


_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PeopleService:
    """Who is entered, who acts where, and what they did."""

    accounts: Accounts
    leases: Leases
    acts: ActRepository
    log: ActLog
    refusals: Guesses  # how many of an address are put on record


@contextlib.asynccontextmanager
async def open_people(
    database: Database, pins: Pins, *, asked_for: bool, alone: bool
) -> AsyncIterator[PeopleService]:
    """Open all that concerns who asks; what was noted of acts is on disk when it closes.

    Raises StorageError where accounts cannot be read. An act that the disk refuses to the last is lost, and
    so is a revocation; the log says how many those were.
    """
    stored = CredentialRepository(database)
    register = Register(stored)
    await register.load()
    acts = ActRepository(database)
    log = ActLog(acts, database.writable)
    elapsed_s = register.time.elapsed_s
    accounts = Accounts(register, pins, asked_for=asked_for, alone=alone)
    _warn_of_pins(accounts)
    following = asyncio.create_task(log.follow(), name="acts")
    revoking = asyncio.create_task(register.follow(database.writable), name="revocations")
    try:
        yield PeopleService(accounts, Leases(elapsed_s), acts, log, Guesses(elapsed_s))
    finally:
        revoking.cancel()
        await asyncio.wait({revoking})
        log.end()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE_S):
                await following


def _warn_of_pins(accounts: Accounts) -> None:
    """Say whose PINs count no more: the database was restored, or came here from another machine."""
    kept = [r for r in accounts.register.credentials if r.kind is CredentialKind.PIN]
    gone = sum(not accounts.pins.counts(record.hash) for record in kept)
    if gone:
        _LOG.warning(
            "PINs (%d) are no longer valid because the database was restored or moved: backups hold no PINs. "
            "Passwords are still valid; each person sets a new PIN at /account.",
            gone,
        )
