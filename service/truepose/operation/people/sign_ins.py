"""Signing in: a password opens a tablet, a PIN says who stands before it now.

A sign-in ends when nobody used it for a shift, after a week, and when it is revoked. That somebody has shown
who they are is fresh for five minutes. All this goes by a clock that nobody sets; a restarted service holds
nothing for fresh.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from truepose.domain.people.accounts import Person
from truepose.operation.people.errors import SignInRefusedError
from truepose.operation.people.guesses import Guesses
from truepose.operation.people.hashes import NOBODYS, badge_hash, fingerprint, matches, new_secret
from truepose.operation.people.register import NOBODY, Caller, Register
from truepose.storage.people.credentials import CredentialKind, CredentialRecord, NewCredential

FRESH_S: Final = 5 * 60.0
IDLE_S: Final = 12 * 3600.0
LONGEST_DAYS: Final = 7
_WRONG_PINS: Final = 10  # in a row; after them only the password proves who it is
_AT_ONCE: Final = 2  # each takes 19 MiB and a processor
_REFUSED: Final = "Name and password do not go together, or the account is no longer open."
_PIN_REFUSED: Final = "Name and PIN do not go together; after too many wrong ones the password is asked for."
_NO_TABLET: Final = "A PIN opens only a tablet that somebody signed in with a password; use yours."
_PROVING: Final = (CredentialKind.PASSWORD, CredentialKind.PIN)


@dataclass(slots=True)
class _Used:
    used_s: float
    shown_s: float | None = None  # when it was last shown who it is; None: not since the service started


@dataclass(frozen=True, slots=True)
class SignedIn:
    """Who is signed in from now on, and the secret that the browser keeps."""

    caller: Caller
    secret: str


class SignIns:
    """Browsers that somebody signed in, and who stands before them."""

    def __init__(self, register: Register, guesses: Guesses, elapsed_s: Callable[[], float]) -> None:
        self._register = register
        self._guesses = guesses
        self._elapsed_s = elapsed_s
        self._used: dict[int, _Used] = {}
        self._wrong_pins: dict[int, int] = {}
        self._places = asyncio.Semaphore(_AT_ONCE)

    def caller_of(self, secret: str) -> Caller:
        """Return who is signed in with what a browser keeps; NOBODY where that opens nothing."""
        record = self._register.opened_by(CredentialKind.SIGN_IN, fingerprint(secret))
        person = None if record is None else self._register.person(record.person_id)
        if record is None or person is None or not self._is_in_use(record):
            return NOBODY
        self._use_of(record.id).used_s = self._elapsed_s()
        return _caller(person, record)

    def lasts(self, caller: Caller) -> bool:
        """Whether a sign-in still opens the service."""
        record = None if caller.sign_in is None else self._register.credential(caller.sign_in)
        return record is not None and self._is_in_use(record)

    def is_fresh(self, caller: Caller) -> bool:
        """Whether it was shown within the last minutes who it is."""
        used = None if caller.sign_in is None else self._used.get(caller.sign_in)
        if used is None or used.shown_s is None:
            return False
        return self._elapsed_s() - used.shown_s <= FRESH_S

    async def sign_in(self, name: str, password: str, tablet: str, address: str) -> SignedIn:
        """Open a tablet by a password; raises SignInRefusedError, TooManyGuessesError."""
        person = self._register.named(name)
        await self._prove(person, name, CredentialKind.PASSWORD, password, address)
        if person is None:
            raise SignInRefusedError(_REFUSED)
        return await self.opened(person, tablet)

    async def opened(self, person: Person, tablet: str) -> SignedIn:
        """Open a tablet for somebody who has shown who they are."""
        self._wrong_pins.pop(person.id, None)
        until = self._register.time.in_future(LONGEST_DAYS)
        return await self._begun(person, until, {"tablet_name": tablet, "opened_by": person.id})

    async def switch(self, here: Caller, who: Person | None, name: str, pin: str, address: str) -> SignedIn:
        """Have somebody else stand before a tablet; raises SignInRefusedError, TooManyGuessesError."""
        record = None if here.sign_in is None else self._register.credential(here.sign_in)
        if record is None or self._register.person(record.document["opened_by"]) is None:
            raise SignInRefusedError(_NO_TABLET)
        await self._prove(who, name, CredentialKind.PIN, pin, address)
        if who is None:
            raise SignInRefusedError(_PIN_REFUSED)
        tablet = {"tablet": here.tablet, **record.document}
        begun = await self._begun(who, record.expires_at, tablet)
        await self._register.revoke(record.id, by=who.name)
        return begun

    async def show(self, here: Caller, kind: CredentialKind, secret: str, address: str) -> None:
        """Have somebody show once more who they are; raises SignInRefusedError, TooManyGuessesError."""
        if here.sign_in is None or here.person is None or kind not in _PROVING:
            raise SignInRefusedError(_NO_TABLET)
        await self._prove(here.person, here.name, kind, secret, address)
        self._use_of(here.sign_in).shown_s = self._elapsed_s()

    async def sign_out(self, here: Caller) -> None:
        """Close a tablet."""
        if here.sign_in is not None:
            self._used.pop(here.sign_in, None)
            await self._register.revoke(here.sign_in, by=here.name)

    async def badge_of(self, badge: str) -> Person | None:
        """Return whose badge it is; None where it is nobody's."""
        kept = [record.hash for record in self._register.credentials if record.kind is CredentialKind.BADGE]
        if not kept:
            return None
        async with self._places:
            found = await asyncio.to_thread(badge_hash, badge, kept)
        record = self._register.opened_by(CredentialKind.BADGE, found)
        return None if record is None else self._register.person(record.person_id)

    async def _prove(
        self, person: Person | None, name: str, kind: CredentialKind, secret: str, address: str
    ) -> None:
        """Raise where a secret is not the person's; whoever is unknown takes as long as everybody else."""
        account = f"account {name.casefold()}" if person is None else f"account {person.id}"
        buckets = (account, f"address {address}")
        self._guesses.take(*buckets)
        kept = () if person is None else self._register.of(person.id, kind)
        async with self._places:
            right = await asyncio.to_thread(matches, kept[-1].hash if kept else NOBODYS, secret)
        if not right or not kept or not self._counts(person, kind):
            self._note_wrong(person, kind)
            raise SignInRefusedError(_PIN_REFUSED if kind is CredentialKind.PIN else _REFUSED)
        self._guesses.give_back(*buckets)
        if person is not None:
            self._wrong_pins.pop(person.id, None)

    def _counts(self, person: Person | None, kind: CredentialKind) -> bool:
        """Whether a secret counts that is right: not a PIN that was guessed at too often."""
        wrong = 0 if person is None else self._wrong_pins.get(person.id, 0)
        return kind is not CredentialKind.PIN or wrong < _WRONG_PINS

    def _note_wrong(self, person: Person | None, kind: CredentialKind) -> None:
        if person is not None and kind is CredentialKind.PIN:
            self._wrong_pins[person.id] = self._wrong_pins.get(person.id, 0) + 1

    async def _begun(self, person: Person, until: str | None, document: dict[str, object]) -> SignedIn:
        secret = new_secret()
        new = NewCredential(CredentialKind.SIGN_IN, person.id, fingerprint(secret), until, dict(document))
        record = await self._register.keep(new)
        now_s = self._elapsed_s()
        self._used[record.id] = _Used(now_s, now_s)
        return SignedIn(_caller(person, record), secret)

    def _is_in_use(self, record: CredentialRecord) -> bool:
        return self._elapsed_s() - self._use_of(record.id).used_s <= IDLE_S

    def _use_of(self, number: int) -> _Used:
        return self._used.setdefault(number, _Used(self._elapsed_s()))


def _caller(person: Person, record: CredentialRecord) -> Caller:
    return Caller(
        person.name,
        person.role,
        person,
        tablet=record.document.get("tablet", record.id),
        tablet_name=record.document.get("tablet_name", ""),
        sign_in=record.id,
    )
