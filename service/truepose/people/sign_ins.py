"""Signing in: a password opens a tablet, a PIN says who stands before it now.

A sign-in ends when nobody used it for a shift, after a week, and when it is revoked. That somebody has shown
who they are is fresh for five minutes. All this goes by a clock that nobody sets; a restarted service holds
nothing for fresh.
"""

import asyncio
from dataclasses import dataclass
from typing import Final

from truepose.domain.people import Person
from truepose.messages.message import message
from truepose.people.attempts import Attempts
from truepose.people.errors import SignInRefusedError
from truepose.people.register import NOBODY, Caller, Register
from truepose.people.secrets import NOBODYS, Pins, badge_hash, fingerprint, matches, new_secret
from truepose.storage.people import CredentialKind, CredentialRecord, NewCredential

FRESH_S: Final = 5 * 60.0
IDLE_S: Final = 12 * 3600.0
LONGEST_DAYS: Final = 7
_AT_ONCE: Final = 2  # each takes 19 MiB and a processor
_REFUSED: Final = message("people.password_refused")
_PIN_REFUSED: Final = message("people.pin_refused")
_PIN_GONE: Final = message("people.pin_gone")
_NO_TABLET: Final = message("people.no_tablet")
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

    def __init__(self, register: Register, attempts: Attempts, pins: Pins) -> None:
        self._register = register
        self._attempts = attempts
        self._pins = pins
        self._elapsed_s = register.time.elapsed_s
        self._used: dict[int, _Used] = {}
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
        with self._attempts.at_door(person, name, address):
            await self._require_password(person, password)
        if person is None:
            raise SignInRefusedError(_REFUSED)
        return await self.opened(person, tablet, address)

    async def opened(self, person: Person, tablet: str, address: str = "") -> SignedIn:
        """Open a tablet for somebody who has shown who they are."""
        self._attempts.places.note(person.id, address)
        self._attempts.pins.forgive(person.id)
        until = self._register.time.in_future(LONGEST_DAYS)
        document = {"tablet_name": tablet, "opened_by": person.id, "address": address}
        return await self._begun(person, until, document)

    async def switch(self, here: Caller, who: Person | None, pin: str) -> SignedIn:
        """Have somebody else stand before a tablet; raises SignInRefusedError, TooManyGuessesError."""
        record = None if here.sign_in is None else self._register.credential(here.sign_in)
        # A PIN counts only at a tablet that a password opened, as long as whoever opened it is let in.
        if record is None or self._register.person(record.document["opened_by"]) is None:
            raise SignInRefusedError(_NO_TABLET)
        with self._attempts.at_tablet(here.tablet):
            await self._require_pin(who, pin, record)
        if who is None:
            raise SignInRefusedError(_PIN_REFUSED)
        # It ends when the sign-in by password would have: PINs do not keep a tablet open beyond that.
        begun = await self._begun(who, record.expires_at, {"tablet": here.tablet, **record.document})
        await self._register.revoke(record.id, by=who.name)
        return begun

    async def show(self, here: Caller, kind: CredentialKind, secret: str) -> None:
        """Have somebody show once more who they are; raises SignInRefusedError, TooManyGuessesError."""
        record = None if here.sign_in is None else self._register.credential(here.sign_in)
        if record is None or here.person is None or kind not in _PROVING:
            raise SignInRefusedError(_NO_TABLET)
        with self._attempts.at_tablet(here.tablet):
            if kind is CredentialKind.PIN:
                await self._require_pin(here.person, secret, record)
            else:
                await self._require_password(here.person, secret)
                self._attempts.pins.forgive(here.person.id)
        self._use_of(record.id).shown_s = self._elapsed_s()

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

    async def _require_password(self, person: Person | None, password: str) -> None:
        # Of a name that nobody has the same hash is worked out: the time tells nothing (decision 0057).
        kept = self._kept(person, CredentialKind.PASSWORD)
        async with self._places:
            right = await asyncio.to_thread(matches, NOBODYS if kept is None else kept, password)
        if not right or kept is None:
            raise SignInRefusedError(_REFUSED)

    async def _require_pin(self, person: Person | None, pin: str, tablet: CredentialRecord) -> None:
        """Raise where a PIN is wrong, or was guessed at there too often."""
        kept = self._kept(person, CredentialKind.PIN)
        async with self._places:
            right = await asyncio.to_thread(self._pins.match, kept, pin)
        if person is None or kept is None:
            raise SignInRefusedError(_PIN_REFUSED)
        if not self._pins.counts(kept):
            raise SignInRefusedError(_PIN_GONE)
        pins, number = self._attempts.pins, tablet.document.get("tablet", tablet.id)
        # Whoever stands or stood here has a count of their own here, so that wrong PINs typed elsewhere under
        # their name do not lock them out.
        if person.id in {tablet.person_id, tablet.document["opened_by"]}:
            pins.note_stood(person.id, number)
        if not right or pins.too_many(person.id, number):
            pins.note_wrong(person.id, number)
            raise SignInRefusedError(_PIN_REFUSED)
        pins.note_right(person.id, number)

    def _kept(self, person: Person | None, kind: CredentialKind) -> str | None:
        kept = () if person is None else self._register.of(person.id, kind)
        return kept[-1].hash if kept else None

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
        # No disk keeps when a sign-in was used last; after a restart the idle time begins with the first
        # look.
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
