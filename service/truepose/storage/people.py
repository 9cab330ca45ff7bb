"""People, what opens the service to them, and what they did.

Of what opens the service only hashes are kept; what ends is revoked, never deleted.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

from sqlalchemy import Connection, Row, Select, func, or_, select

from truepose.domain.people import Person, Role
from truepose.storage.engine.raw_connection import plain
from truepose.storage.queries import Repository
from truepose.storage.record_insertion import add_row, add_rows
from truepose.storage.records import Page
from truepose.storage.rows import from_row, to_row
from truepose.storage.secret_files import take_out_pins
from truepose.storage.tables import acts, credentials, people, person_states, revocations


class CredentialKind(StrEnum):
    """What opens the service, and to what."""

    PASSWORD = "password"
    PIN = "pin"  # on a tablet that somebody signed in
    BADGE = "badge"  # says who; the PIN proves it
    TOKEN = "token"  # of a program
    SIGN_IN = "sign_in"  # of a browser
    LINK = "link"  # once, to choose a password
    WATCH = "watch"  # one session, for looking at it


@dataclass(frozen=True, slots=True)
class CredentialRecord:
    """Something that opens the service, without the secret itself."""

    id: int
    recorded_at: str
    kind: CredentialKind
    person_id: int | None  # None: of nobody yet
    hash: str
    expires_at: str | None  # UTC, ISO 8601; None: until it is revoked
    document: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class NewCredential:
    """What is to be kept of something that opens the service."""

    kind: CredentialKind
    person_id: int | None
    hash: str
    expires_at: str | None = None
    document: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ShownAt:
    """From where somebody signed in, who may have signed out since."""

    person_id: int
    address: str
    since: str  # UTC, ISO 8601


@dataclass(frozen=True, slots=True)
class EnteredPeople:
    """Everybody who was ever entered, and what opens the service now."""

    people: tuple[Person, ...]
    credentials: tuple[CredentialRecord, ...]
    newest: str | None  # when the last credential was written, also one that is revoked by now
    places: tuple[ShownAt, ...]  # each once, as of the newest sign-in there


class CredentialRepository(Repository):
    """All queries about people and what opens the service to them."""

    async def entered(self) -> EnteredPeople:
        """Return everything that counts now."""
        return await self._database.read(_entered)

    async def enter(
        self, name: str, role: Role, by: str, new: Sequence[NewCredential] = ()
    ) -> tuple[Person, tuple[CredentialRecord, ...]]:
        """Enter somebody with what opens the service to them, whoever that is said to be of: all or none."""

        def work(connection: Connection) -> tuple[Person, tuple[CredentialRecord, ...]]:
            person = Person(add_row(connection, people, name=name), name, role)
            _add_state(connection, person, by)
            return person, _added(connection, [replace(one, person_id=person.id) for one in new])

        return await self._database.write(work)

    async def change(
        self, person: Person, by: str, new: Sequence[NewCredential] = (), gone: Sequence[int] = ()
    ) -> tuple[CredentialRecord, ...]:
        """Record what somebody may do from now on, and exchange what opens the service to them."""

        def work(connection: Connection) -> tuple[CredentialRecord, ...]:
            _add_state(connection, person, by)
            return _exchanged(connection, new, gone, by)

        return await self._database.write(work)

    async def exchange(
        self, new: Sequence[NewCredential], gone: Sequence[int], by: str
    ) -> tuple[CredentialRecord, ...]:
        """Keep what opens the service from now on, and record what opens nothing any more: all or none."""
        return await self._database.write(lambda c: _exchanged(c, new, gone, by))

    async def revoke(self, numbers: Sequence[int], by: str) -> None:
        """Record that these open nothing any more."""
        await self.exchange((), numbers, by)


def _add_state(connection: Connection, person: Person, by: str) -> None:
    values = {"person_id": person.id, "role": person.role.value, "active": int(person.active), "by": by}
    add_row(connection, person_states, **values)


def _exchanged(
    connection: Connection, new: Sequence[NewCredential], gone: Sequence[int], by: str
) -> tuple[CredentialRecord, ...]:
    if gone:
        # Revoked, not deleted: who could come in until when has to stay on record.
        add_rows(connection, revocations, [{"credential_id": number, "by": by} for number in gone])
        # In the same transaction: between two of them the hash of a PIN that counts no more could be read
        # (commit 78613b0d).
        take_out_pins(plain(connection), revoked_only=True)
    return _added(connection, new)


def _added(connection: Connection, new: Iterable[NewCredential]) -> tuple[CredentialRecord, ...]:
    numbers = [add_row(connection, credentials, **to_row(one, credentials)) for one in new]
    found = connection.execute(
        select(credentials).where(credentials.c.id.in_(numbers)).order_by(credentials.c.id)
    )
    return tuple(from_row(CredentialRecord, row) for row in found)


def _entered(connection: Connection) -> EnteredPeople:
    newest = select(func.max(person_states.c.id)).group_by(person_states.c.person_id)
    known = (
        select(people.c.id, people.c.name, person_states.c.role, person_states.c.active)
        .join(person_states, person_states.c.person_id == people.c.id)
        .where(person_states.c.id.in_(newest))
        .order_by(people.c.id)
    )
    valid = (
        select(credentials)
        .where(credentials.c.id.not_in(select(revocations.c.credential_id)))
        .order_by(credentials.c.id)
    )
    return EnteredPeople(
        tuple(from_row(Person, row) for row in connection.execute(known)),
        tuple(from_row(CredentialRecord, row) for row in connection.execute(valid)),
        connection.scalar(select(func.max(credentials.c.recorded_at))),
        _places(connection),
    )


def _places(connection: Connection) -> tuple[ShownAt, ...]:
    # Revoked ones too: guesses from an address at which somebody once signed in are told from those of
    # strangers, also after they have signed out (commit 94ae199f).
    of_sign_ins = select(credentials).where(credentials.c.kind == CredentialKind.SIGN_IN.value)
    newest: dict[tuple[int, str], ShownAt] = {}
    for row in connection.execute(of_sign_ins.order_by(credentials.c.id)):
        address = row.document.get("address")
        if address:
            newest[row.person_id, address] = ShownAt(row.person_id, address, row.recorded_at)
    return tuple(newest.values())


@dataclass(frozen=True, slots=True)
class PersonsAct:
    """One request that changed something, or that was refused."""

    happened_at: str  # UTC, ISO 8601
    operation: str
    resource: str  # path, without what is secret in it
    status: int
    person: str | None = None  # None: nobody who is known
    role: str | None = None
    how: str | None = None  # sign_in, token
    tablet: str | None = None
    address: str | None = None
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class ActRecord:
    """An act as it was stored."""

    id: int
    recorded_at: str
    act: PersonsAct


class ActRepository(Repository):
    """All queries about acts."""

    async def add(self, several: Sequence[PersonsAct]) -> None:
        """Keep acts in their order, all or none."""
        rows = [to_row(act, acts) for act in several]
        # Not `write_new`: what people did is recorded also while only the reserve is left.
        await self._database.write(lambda connection: add_rows(connection, acts, rows))

    async def page(self, page: Page, search: str = "") -> list[ActRecord]:
        """Return acts in which `search` stands, oldest first."""
        query = _found(search).where(acts.c.id > page.after).order_by(acts.c.id).limit(page.limit)
        return await self._each(query, _record)

    async def newest(self, before: int | None, limit: int, search: str = "") -> list[ActRecord]:
        """Return the acts before number `before`, newest first."""
        query = _found(search).order_by(acts.c.id.desc()).limit(limit)
        return await self._each(query if before is None else query.where(acts.c.id < before), _record)

    async def with_reason(self, operation: str, resource: str) -> list[ActRecord]:
        """Return the acts of an operation on a resource that succeeded and gave a reason, oldest first."""
        done = (acts.c.operation == operation) & (acts.c.resource == resource) & (acts.c.status < 400)
        query = select(acts).where(done, acts.c.reason.is_not(None)).order_by(acts.c.id)
        return await self._each(query, _record)

    async def count(self, search: str = "") -> int:
        """Return in how many acts `search` stands."""
        query = select(func.count()).select_from(_found(search).subquery())
        return await self._value(query) or 0


_SEARCHED = (acts.c.person, acts.c.operation, acts.c.resource, acts.c.reason, acts.c.address)


def _found(search: str) -> Select[Any]:
    if not search:
        return select(acts)
    return select(acts).where(or_(*(column.icontains(search, autoescape=True) for column in _SEARCHED)))


def _record(row: Row[Any]) -> ActRecord:
    return from_row(ActRecord, row, act=from_row(PersonsAct, row))
