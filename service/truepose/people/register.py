"""Everybody who was entered, and what opens the service: in memory as in the database.

No other process writes to the database of a running service, so a request is judged without asking it.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.errors import RecordRefusedError
from truepose.domain.people import MACHINE, OF_PROGRAMS, Person, Role, fault_of_name, same_person, tidy_name
from truepose.messages.message import message
from truepose.people.errors import AccountRefusedError, SignInRefusedError, UnknownPersonError
from truepose.people.steady_time import SteadyTime
from truepose.storage.people import (
    CredentialKind,
    CredentialRecord,
    CredentialRepository,
    NewCredential,
    ShownAt,
)

LINK_IS_OVER: Final = message("people.link_is_over")
_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Caller:
    """Who asks."""

    name: str = ""
    role: Role | None = None  # None: of nobody
    person: Person | None = None
    tablet: int | None = None  # a browser that somebody signed in; persons change on it
    tablet_name: str = ""
    sign_in: int | None = None  # number of the credential
    token: int | None = None
    everybody: bool = False  # the service is open: nobody is asked who they are
    machine: bool = False  # a command of the machine's administrator, who says who is let in


NOBODY = Caller()
EVERYBODY = Caller(everybody=True)
OF_MACHINE = Caller(MACHINE, Role.ADMINISTRATOR, machine=True)


class Register:
    """People and credentials that count now."""

    def __init__(self, stored: CredentialRepository) -> None:
        self._stored = stored
        self._people: dict[int, Person] = {}
        self._credentials: dict[int, CredentialRecord] = {}
        self._by_hash: dict[tuple[CredentialKind, str], int] = {}
        self.places: tuple[ShownAt, ...] = ()  # as the database had them at the start
        # One change at a time: each is judged by what there is when it is made, and not by what somebody saw.
        self._turn = asyncio.Lock()
        self._owed: dict[int, str] = {}  # revoked, by whom, and not on record yet
        self._refused = asyncio.Event()  # by the disk
        self.time = SteadyTime()

    async def load(self) -> None:
        """Read what the database holds."""
        entered = await self._stored.entered()
        self._people = {person.id: person for person in entered.people}
        self.places = entered.places
        self.time = SteadyTime(entered.newest)
        self._take(*entered.credentials)

    @property
    def people(self) -> tuple[Person, ...]:
        """Everybody who was ever entered, oldest first."""
        return tuple(self._people.values())

    @property
    def credentials(self) -> tuple[CredentialRecord, ...]:
        """What opens the service now, oldest first."""
        return tuple(record for record in self._credentials.values() if self.is_valid(record))

    def person(self, number: int | None) -> Person | None:
        """Return somebody who was entered and not removed."""
        found = None if number is None else self._people.get(number)
        return found if found is not None and found.active else None

    def named(self, name: str) -> Person | None:
        """Return whoever has that name, also where they were removed."""
        return next((person for person in self._people.values() if same_person(person.name, name)), None)

    def require(self, name: str) -> Person:
        """Return somebody who was entered and not removed; raises UnknownPersonError."""
        found = self.named(name)
        if found is None or not found.active:
            raise UnknownPersonError(message("people.unknown", person=tidy_name(name)))
        return found

    def is_valid(self, record: CredentialRecord) -> bool:
        """Whether a credential still opens something: it has not expired, and its person is not removed."""
        of_somebody = record.person_id is None or self.person(record.person_id) is not None
        return of_somebody and not self.time.is_over(record.expires_at)

    def of(self, person_id: int, *kinds: CredentialKind) -> tuple[CredentialRecord, ...]:
        """Return the credentials of a person of these kinds."""
        return tuple(r for r in self.credentials if r.person_id == person_id and r.kind in kinds)

    def opened_by(self, kind: CredentialKind, kept: str) -> CredentialRecord | None:
        """Return the credential of a hash; None where it opens nothing, or nothing any more."""
        number = self._by_hash.get((kind, kept))
        return None if number is None else self.credential(number)

    def credential(self, number: int) -> CredentialRecord | None:
        """Return what opens the service under this number; None where nothing does."""
        found = self._credentials.get(number)
        return found if found is not None and self.is_valid(found) else None

    async def enter(self, name: str, role: Role, by: str, *new: NewCredential) -> Person:
        """Enter somebody with what opens the service to them.

        Raises AccountRefusedError where the name cannot be read or is taken.
        """
        tidy = _readable(name)
        _require_of_people(role)
        async with self._turn:
            known = self.named(tidy)
            if known is not None and known.active:
                raise AccountRefusedError(message("people.entered", person=known.name))
            if known is None:
                return await self._entered(tidy, role, by, new)
            # What is left of theirs, if anything, was not meant for whoever they are now.
            return await self._changed(
                replace(known, role=role, active=True), by, new, self._all_of(known, *CredentialKind)
            )

    async def enter_first(self, name: str, *new: NewCredential) -> Person:
        """Enter the first person, an administrator; raises SignInRefusedError, AccountRefusedError."""
        tidy = _readable(name)
        async with self._turn:
            if self._people:  # two have the printed link
                raise SignInRefusedError(LINK_IS_OVER)
            return await self._entered(tidy, Role.ADMINISTRATOR, tidy, new)

    async def change_role(self, person: Person, role: Role, by: str) -> Person:
        """Give somebody another role.

        Raises AccountRefusedError for the last administrator, UnknownPersonError for whoever is removed.
        """
        _require_of_people(role)
        async with self._turn:
            now = self._require_present(person)
            if role is not Role.ADMINISTRATOR:
                self._require_another_administrator(now)
            return await self._changed(replace(now, role=role), by)

    async def remove(self, person: Person, by: str) -> None:
        """Let somebody in no more; raises as `change_role`."""
        async with self._turn:
            now = self._require_present(person)
            self._require_another_administrator(now)
            gone = self._all_of(now, *CredentialKind)
            await self._changed(replace(now, active=False), by, gone=gone)

    async def keep(self, new: NewCredential, *, resting_on: Collection[int] = ()) -> CredentialRecord:
        """Have something open the service, as long as what it rests on does.

        Parameters
        ----------
        new : NewCredential
        resting_on : collection of int
            Numbers of credentials by which it was shown who somebody is.

        Raises
        ------
        SignInRefusedError
            What it rests on, or its person, was taken back meanwhile.
        """
        async with self._turn:
            self._require_standing(new, resting_on)
            (record,) = await self._exchanged([new], (), "")
            return record

    async def put(
        self,
        person: Person,
        new: Sequence[NewCredential],
        *,
        ends: Collection[CredentialKind] = (),
        resting_on: Collection[int] = (),
        by: str,
    ) -> tuple[CredentialRecord, ...]:
        """Have these open the service in the place of what a person had of their kinds, and of others.

        Parameters
        ----------
        person : Person
        new : sequence of NewCredential
            All of this person.
        ends : collection of CredentialKind
            Kinds of which nothing of theirs opens the service from then on.
        resting_on : collection of int
            As of `keep`.
        by : str

        Raises
        ------
        SignInRefusedError
            As `keep`.
        AccountRefusedError
            A badge is somebody else's.
        """
        async with self._turn:
            for one in new:
                self._require_standing(one, resting_on)
                self._require_own_badge(one)
            gone = self._all_of(person, *ends, *(one.kind for one in new))
            return await self._exchanged(new, gone, by)

    async def revoke(self, *numbers: int, by: str) -> None:
        """Have these open nothing any more, from this moment on.

        Raises RecordRefusedError where the disk does not take note of it yet; then `follow` sees to that.
        """
        # Out of memory first: they open nothing while the disk is written to, nor where it refuses.
        self._owed |= {number: by for number in numbers if self._drop(number)}
        await self._settle()

    async def follow(self, writable: Callable[[], Awaitable[None]]) -> None:
        """Put on record what was revoked while the disk refused, as long as the service runs."""
        try:
            while True:
                await self._refused.wait()
                await writable()
                self._refused.clear()
                with contextlib.suppress(RecordRefusedError):
                    await self._settle()
        finally:
            if self._owed:
                _LOG.error("%d revocations could not be recorded", len(self._owed))

    async def _settle(self) -> None:
        for by in {*self._owed.values()}:
            numbers = [number for number, who in self._owed.items() if who == by]
            try:
                await self._stored.revoke(numbers, by)
            except RecordRefusedError:
                self._refused.set()
                raise
            for number in numbers:
                self._owed.pop(number, None)

    async def _entered(self, name: str, role: Role, by: str, new: Sequence[NewCredential]) -> Person:
        person, records = await self._stored.enter(name, role, by, new)
        self._people[person.id] = person
        self._take(*records)
        return person

    async def _changed(
        self, person: Person, by: str, new: Sequence[NewCredential] = (), gone: Sequence[int] = ()
    ) -> Person:
        of_them = [replace(one, person_id=person.id) for one in new]
        records = await self._stored.change(person, by, of_them, gone)
        self._people[person.id] = person
        self._drop(*gone)
        self._take(*records)
        return person

    async def _exchanged(
        self, new: Sequence[NewCredential], gone: Sequence[int], by: str
    ) -> tuple[CredentialRecord, ...]:
        # On disk first: what the disk refuses opens nothing, as it would not after a restart, and what there
        # was opens the service still.
        records = await self._stored.exchange(new, gone, by)
        self._drop(*gone)
        self._take(*records)
        return records

    def _take(self, *records: CredentialRecord) -> None:
        for record in records:
            self._credentials[record.id] = record
            self._by_hash[record.kind, record.hash] = record.id
        # Years of browsers and links have expired, and open nothing.
        self._drop(*(r.id for r in self._credentials.values() if self.time.is_over(r.expires_at)))

    def _drop(self, *numbers: int) -> bool:
        """Forget credentials; return whether all of them were there."""
        found = [self._credentials.pop(number, None) for number in numbers]
        for record in found:
            if record is not None and self._by_hash.get((record.kind, record.hash)) == record.id:
                del self._by_hash[record.kind, record.hash]
        return None not in found

    def _all_of(self, person: Person, *kinds: CredentialKind) -> tuple[int, ...]:
        return tuple(r.id for r in self._credentials.values() if r.person_id == person.id and r.kind in kinds)

    def _require_present(self, person: Person) -> Person:
        """Return somebody as they are now, whatever was known of them when they were asked for."""
        now = self.person(person.id)
        if now is None:
            raise UnknownPersonError(message("people.unknown", person=person.name))
        return now

    def _require_standing(self, new: NewCredential, resting_on: Collection[int]) -> None:
        is_gone = new.person_id is not None and self.person(new.person_id) is None
        if is_gone or any(self.credential(number) is None for number in resting_on):
            raise SignInRefusedError(message("people.ended_meanwhile"))

    def _require_own_badge(self, new: NewCredential) -> None:
        same = self.opened_by(new.kind, new.hash) if new.kind is CredentialKind.BADGE else None
        if same is not None and same.person_id != new.person_id:
            raise AccountRefusedError(message("people.badge"))

    def _require_another_administrator(self, person: Person) -> None:
        others = [
            p
            for p in self._people.values()
            if p.active and p.role is Role.ADMINISTRATOR and p.id != person.id
        ]
        if not others:
            raise AccountRefusedError(message("people.only_administrator", person=person.name))


def _readable(name: str) -> str:
    """Return a name as it is kept; raises AccountRefusedError where it cannot be read."""
    tidy = tidy_name(name)
    fault = fault_of_name(tidy)
    if fault is not None:
        raise AccountRefusedError(message("people.unreadable", fault=fault))
    return tidy


def _require_of_people(role: Role) -> None:
    if role in OF_PROGRAMS:
        raise AccountRefusedError(message("people.no_person", role=role.value))
