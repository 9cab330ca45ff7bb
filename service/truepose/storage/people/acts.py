"""The acts: what was asked of the service to change, by whom, from where, and what came of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, Select, func, or_, select

from truepose.storage.database import Database
from truepose.storage.records import Page
from truepose.storage.rows import add_rows
from truepose.storage.tables import acts


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


class ActRepository:
    """All queries about acts."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add(self, several: Sequence[PersonsAct]) -> None:
        """Keep acts in their order, all or none."""
        rows = [{name: getattr(act, name) for name in _COLUMNS} for act in several]
        await self._database.write(lambda connection: add_rows(connection, acts, rows))

    async def page(self, page: Page, search: str = "") -> list[ActRecord]:
        """Return acts in which `search` stands, oldest first."""
        query = _found(search).where(acts.c.id > page.after).order_by(acts.c.id).limit(page.limit)
        return await self._read(query)

    async def newest(self, before: int | None, limit: int, search: str = "") -> list[ActRecord]:
        """Return the acts before number `before`, newest first."""
        query = _found(search).order_by(acts.c.id.desc()).limit(limit)
        return await self._read(query if before is None else query.where(acts.c.id < before))

    async def with_reason(self, operation: str, resource: str) -> list[ActRecord]:
        """Return the acts of an operation on a resource that succeeded and gave a reason, oldest first."""
        done = (acts.c.operation == operation) & (acts.c.resource == resource) & (acts.c.status < 400)
        return await self._read(select(acts).where(done, acts.c.reason.is_not(None)).order_by(acts.c.id))

    async def count(self, search: str = "") -> int:
        """Return in how many acts `search` stands."""
        query = select(func.count()).select_from(_found(search).subquery())
        return await self._database.read(lambda c: c.execute(query).scalar_one())

    async def _read(self, query: Select[Any]) -> list[ActRecord]:
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])


_COLUMNS = tuple(PersonsAct.__dataclass_fields__)
_SEARCHED = (acts.c.person, acts.c.operation, acts.c.resource, acts.c.reason, acts.c.address)


def _found(search: str) -> Select[Any]:
    if not search:
        return select(acts)
    return select(acts).where(or_(*(column.icontains(search, autoescape=True) for column in _SEARCHED)))


def _record(row: Row[Any]) -> ActRecord:
    return ActRecord(row.id, row.recorded_at, PersonsAct(*(getattr(row, name) for name in _COLUMNS)))
