"""Everybody who was entered, and what opens the service: in memory as in the database.

No other process writes to the database of a running service, so a request is judged without asking it.
"""

import asyncio
from dataclasses import dataclass, replace

from truepose.domain.people import MACHINE, OF_PROGRAMS, Person, Role, fault_of_name, same_person, tidy_name
from truepose.messages.message import message
from truepose.people.errors import AccountRefusedError, UnknownPersonError
from truepose.people.steady_time import SteadyTime
from truepose.storage.people import (
    CredentialKind,
    CredentialRecord,
    CredentialRepository,
    NewCredential,
    ShownAt,
)


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
        self._turn = asyncio.Lock()  # two of one name must not be entered at once
        self.time = SteadyTime()

    async def load(self) -> None:
        """Read what the database holds."""
        entered = await self._stored.entered()
        self._people = {person.id: person for person in entered.people}
        for record in entered.credentials:
            self._take(record)
        self.places = entered.places
        self.time = SteadyTime(entered.newest)

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

    async def enter(self, name: str, role: Role, by: str) -> Person:
        """Enter somebody; raises AccountRefusedError where the name cannot be read or is taken."""
        tidy = tidy_name(name)
        fault = fault_of_name(tidy)
        if fault is not None:
            raise AccountRefusedError(message("people.unreadable", fault=fault))
        _require_of_people(role)
        async with self._turn:
            known = self.named(tidy)
            if known is not None and known.active:
                raise AccountRefusedError(message("people.entered", person=known.name))
            if known is not None:
                return await self._changed(replace(known, role=role, active=True), by)
            person = await self._stored.enter(tidy, role, by)
            self._people[person.id] = person
            return person

    async def change_role(self, person: Person, role: Role, by: str) -> Person:
        """Give somebody another role; raises AccountRefusedError for the last administrator."""
        _require_of_people(role)
        async with self._turn:
            if role is not Role.ADMINISTRATOR:
                self._require_another_administrator(person)
            return await self._changed(replace(person, role=role), by)

    async def remove(self, person: Person, by: str) -> None:
        """Let somebody in no more; raises AccountRefusedError for the last administrator."""
        async with self._turn:
            self._require_another_administrator(person)
            gone = [r.id for r in self._credentials.values() if r.person_id == person.id]
            await self._changed(replace(person, active=False), by)
        await self.revoke(*gone, by=by)

    async def keep(self, new: NewCredential) -> CredentialRecord:
        """Have something open the service."""
        # On disk first: what the disk refuses opens nothing, as it would not after a restart.
        record = await self._stored.add(new)
        self._take(record)
        return record

    async def put(self, new: NewCredential, by: str) -> CredentialRecord:
        """Have something open the service in the place of what a person had of that kind."""
        before = [
            r.id for r in self._credentials.values() if (r.person_id, r.kind) == (new.person_id, new.kind)
        ]
        # The new one first: where the disk refuses it, what the person had opens the service still.
        record = await self.keep(new)
        await self.revoke(*before, by=by)
        return record

    async def revoke(self, *numbers: int, by: str) -> None:
        """Have these open nothing any more, from this moment on."""
        # Out of memory first: they open nothing while the disk is written to, nor where it refuses.
        for number in numbers:
            self._credentials.pop(number, None)
        await self._stored.revoke(numbers, by)

    def _take(self, record: CredentialRecord) -> None:
        self._credentials[record.id] = record
        self._by_hash[record.kind, record.hash] = record.id

    async def _changed(self, person: Person, by: str) -> Person:
        await self._stored.change(person, by)
        self._people[person.id] = person
        return person

    def _require_another_administrator(self, person: Person) -> None:
        others = [
            p for p in self._people.values() if p.active and p.role is Role.ADMINISTRATOR and p != person
        ]
        if not others:
            raise AccountRefusedError(message("people.only_administrator", person=person.name))


def _require_of_people(role: Role) -> None:
    if role in OF_PROGRAMS:
        raise AccountRefusedError(message("people.no_person", role=role.value))
