"""Signing in: a password opens a tablet, a PIN says who stands before it now.

A sign-in ends when nobody used it for a shift, after a week, and when it is revoked. That somebody has shown
who they are is fresh for five minutes. All this goes by a clock that nobody sets; a restarted service holds
nothing for fresh.
"""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

from truepose.domain.people import Person
from truepose.messages.message import message
from truepose.people.attempts import Attempts
from truepose.people.errors import SignInRefusedError
from truepose.people.register import NOBODY, Caller, Register
from truepose.people.secrets import NOBODYS, Badges, Pins, SlowHashes, fingerprint, matches, new_secret
from truepose.storage.people import CredentialKind, CredentialRecord, NewCredential

FRESH_S: Final = 5 * 60.0
IDLE_S: Final = 12 * 3600.0
LONGEST_DAYS: Final = 7
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

    def __init__(
        self, register: Register, attempts: Attempts, pins: Pins, badges: Badges, hashes: SlowHashes
    ) -> None:
        self._register = register
        self._attempts = attempts
        self._pins = pins
        self._badges = badges
        self._hashes = hashes
        self._elapsed_s = register.time.elapsed_s
        self._used: dict[int, _Used] = {}

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
            shown = await self._require_password(person, password)
        if person is None:
            raise SignInRefusedError(_REFUSED)
        return await self.opened(person, tablet, address, resting_on=[shown])

    async def opened(
        self, person: Person, tablet: str, address: str = "", *, resting_on: Collection[int] = ()
    ) -> SignedIn:
        """Open a tablet for somebody who has shown who they are, by credentials of these numbers."""
        until = self._register.time.in_future(LONGEST_DAYS)
        document = {"tablet_name": tablet, "opened_by": person.id, "address": address}
        begun = await self._begun(person, until, document, resting_on)
        self._attempts.places.note(person.id, address)
        self._attempts.pins.forgive(person.id)
        return begun

    async def switch(self, here: Caller, name: str | None, badge: str | None, pin: str) -> SignedIn:
        """Have somebody else, of a name or a badge, stand before a tablet; raises as `sign_in`."""
        record = None if here.sign_in is None else self._register.credential(here.sign_in)
        # A PIN counts only at a tablet that a password opened, as long as whoever opened it is let in.
        if record is None or self._register.person(record.document["opened_by"]) is None:
            raise SignInRefusedError(_NO_TABLET)
        with self._attempts.at_tablet(here.tablet):
            who = await self._meant(name, badge)
            shown = await self._require_pin(who, pin, record)
        if who is None:
            raise SignInRefusedError(_PIN_REFUSED)
        document = {"tablet": here.tablet, **record.document}
        # It ends when the sign-in by password would have: PINs do not keep a tablet open beyond that.
        begun = await self._begun(who, record.expires_at, document, [record.id, shown])
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

    async def _meant(self, name: str | None, badge: str | None) -> Person | None:
        """Return whom a name or a badge means; None: nobody."""
        if badge is None:
            return None if name is None else self._register.named(name)
        found = await self._hashes.of(self._badges.hashed, badge)
        record = self._register.opened_by(CredentialKind.BADGE, found)
        return None if record is None else self._register.person(record.person_id)

    async def _require_password(self, person: Person | None, password: str) -> int:
        """Return the number of the password that is right; raises SignInRefusedError."""
        # Of a name that nobody has the same hash is worked out: the time tells nothing (decision 0057).
        kept = self._kept(person, CredentialKind.PASSWORD)
        right = await self._hashes.of(matches, NOBODYS if kept is None else kept.hash, password)
        if not right or kept is None:
            raise SignInRefusedError(_REFUSED)
        return kept.id

    async def _require_pin(self, person: Person | None, pin: str, tablet: CredentialRecord) -> int:
        """Return the number of the PIN; raises where it is wrong, or was guessed at there too often."""
        kept = self._kept(person, CredentialKind.PIN)
        right = await self._hashes.of(self._pins.match, None if kept is None else kept.hash, pin)
        if person is None or kept is None:
            raise SignInRefusedError(_PIN_REFUSED)
        if not self._pins.counts(kept.hash):
            raise SignInRefusedError(_PIN_GONE)
        pins, number = self._attempts.pins, _tablet_of(tablet)
        # Whoever stands or stood here has a count of their own here, so that wrong PINs typed elsewhere under
        # their name do not lock them out.
        if person.id in {tablet.person_id, tablet.document["opened_by"]}:
            pins.note_stood(person.id, number)
        if not right or pins.too_many(person.id, number):
            pins.note_wrong(person.id, number)
            raise SignInRefusedError(_PIN_REFUSED)
        pins.note_right(person.id, number)
        return kept.id

    def _kept(self, person: Person | None, kind: CredentialKind) -> CredentialRecord | None:
        kept = () if person is None else self._register.of(person.id, kind)
        return kept[-1] if kept else None

    async def _begun(
        self, person: Person, until: str | None, document: dict[str, object], resting_on: Collection[int]
    ) -> SignedIn:
        secret = new_secret()
        new = NewCredential(CredentialKind.SIGN_IN, person.id, fingerprint(secret), until, dict(document))
        record = await self._register.keep(new, resting_on=resting_on)
        self._forget_ended()
        now_s = self._elapsed_s()
        self._used[record.id] = _Used(now_s, now_s)
        return SignedIn(_caller(person, record), secret)

    def _forget_ended(self) -> None:
        there = [r for r in self._register.credentials if r.kind is CredentialKind.SIGN_IN]
        self._used = {r.id: self._used[r.id] for r in there if r.id in self._used}
        self._attempts.pins.forget_others({_tablet_of(r) for r in there})

    def _is_in_use(self, record: CredentialRecord) -> bool:
        return self._elapsed_s() - self._use_of(record.id).used_s <= IDLE_S

    def _use_of(self, number: int) -> _Used:
        # No disk keeps when a sign-in was used last; after a restart the idle time begins with the first
        # look.
        return self._used.setdefault(number, _Used(self._elapsed_s()))


def _tablet_of(record: CredentialRecord) -> int:
    """Return the number of a tablet: of the sign-in that opened it."""
    number: int = record.document.get("tablet", record.id)
    return number


def _caller(person: Person, record: CredentialRecord) -> Caller:
    return Caller(
        person.name,
        person.role,
        person,
        tablet=_tablet_of(record),
        tablet_name=record.document.get("tablet_name", ""),
        sign_in=record.id,
    )
