"""People and what opens the service to them. Only hashes are kept; what ends is revoked, never deleted."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from sqlalchemy import Connection, Row, func, select

from truepose.domain.people.accounts import Person, Role
from truepose.storage.connection.plain import plain
from truepose.storage.database import Database
from truepose.storage.integrity.taken_out import take_out_pins
from truepose.storage.rows import add_row, add_rows
from truepose.storage.tables import credentials, people, person_states, revocations


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
class Entered:
    """Everybody who was ever entered, and what opens the service now."""

    people: tuple[Person, ...]
    credentials: tuple[CredentialRecord, ...]
    newest: str | None  # when the last of these records was written
    places: tuple[ShownAt, ...]  # oldest first


class CredentialRepository:
    """All queries about people and what opens the service to them."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def entered(self) -> Entered:
        """Return everything that counts now."""
        return await self._database.read(_entered)

    async def enter(self, name: str, role: Role, by: str) -> Person:
        """Enter somebody."""

        def work(connection: Connection) -> int:
            number = add_row(connection, people, name=name)
            add_row(connection, person_states, person_id=number, role=role.value, active=1, by=by)
            return number

        return Person(await self._database.write(work), name, role)

    async def change(self, person: Person, by: str) -> None:
        """Record what somebody may do from now on."""
        values = {"person_id": person.id, "role": person.role.value, "active": int(person.active), "by": by}
        await self._database.write(lambda c: add_row(c, person_states, **values))

    async def add(self, new: NewCredential) -> CredentialRecord:
        """Keep something that opens the service."""

        def work(connection: Connection) -> CredentialRecord:
            number = add_row(
                connection,
                credentials,
                kind=new.kind.value,
                person_id=new.person_id,
                hash=new.hash,
                expires_at=new.expires_at,
                document=new.document,
            )
            found = connection.execute(select(credentials).where(credentials.c.id == number)).one()
            return _credential(found)

        return await self._database.write(work)

    async def revoke(self, numbers: tuple[int, ...], by: str) -> None:
        """Record that these open nothing any more."""
        rows = [{"credential_id": number, "by": by} for number in numbers]

        def work(connection: Connection) -> None:
            add_rows(connection, revocations, rows)
            take_out_pins(plain(connection), revoked_only=True)

        if rows:
            await self._database.write(work)

    async def take_out_revoked(self) -> None:
        """Take out PINs that an older version has left where they count no more."""
        await self._database.write(lambda connection: take_out_pins(plain(connection), revoked_only=True))


def _entered(connection: Connection) -> Entered:
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
    return Entered(
        tuple(
            Person(row.id, row.name, Role(row.role), bool(row.active)) for row in connection.execute(known)
        ),
        tuple(_credential(row) for row in connection.execute(valid)),
        connection.scalar(select(func.max(credentials.c.recorded_at))),
        tuple(_places(connection)),
    )


def _places(connection: Connection) -> Iterator[ShownAt]:
    of_sign_ins = select(credentials).where(credentials.c.kind == CredentialKind.SIGN_IN.value)
    for row in connection.execute(of_sign_ins.order_by(credentials.c.id)):
        if row.document.get("address"):
            yield ShownAt(row.person_id, row.document["address"], row.recorded_at)


def _credential(row: Row[Any]) -> CredentialRecord:
    kind = CredentialKind(row.kind)
    return CredentialRecord(
        row.id, row.recorded_at, kind, row.person_id, row.hash, row.expires_at, row.document
    )
