"""Lists over all kinds of records: newest first, searched, a page at a time."""

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Select, func, select, union_all

from truepose.storage.database import Database
from truepose.storage.tables import campaigns, diagnoses
from truepose.storage.work.items import SOURCES, WorkItem, WorkKind, item_of


@dataclass(frozen=True, slots=True)
class WorkPage:
    """Some items of a list, and how many it has."""

    items: tuple[WorkItem, ...]
    total: int


@dataclass(frozen=True, slots=True)
class KnownRobot:
    """A robot of which something is recorded."""

    name: str
    serial_number: str  # empty where nobody said it
    campaigns: int
    diagnoses: int


class WorkList:
    """Queries over all kinds of records at once."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def page(
        self, kinds: Collection[WorkKind], texts: Sequence[str] = (), *, skip: int = 0, limit: int = 50
    ) -> WorkPage:
        """Return the records of some kinds in which one of `texts` stands (none: all), newest first."""
        return await self._database.read(lambda c: _page(c, kinds, tuple(texts), skip, limit))

    async def robots(self) -> list[KnownRobot]:
        """Return the robots of which there are campaigns, the busiest first."""
        rows = await self._database.read(lambda c: c.execute(_robots()).all())
        return [KnownRobot(row.robot, row.serial_number, row.campaigns, row.diagnoses) for row in rows]


def _page(
    connection: Connection, kinds: Collection[WorkKind], texts: tuple[str, ...], skip: int, limit: int
) -> WorkPage:
    listed = union_all(*(SOURCES[kind].numbers(kind, texts) for kind in kinds)).subquery()
    total = connection.scalar(select(func.count()).select_from(listed)) or 0
    newest = select(listed).order_by(listed.c.recorded_at.desc(), listed.c.id.desc(), listed.c.kind)
    rows = connection.execute(newest.offset(skip).limit(limit)).all()
    wanted = [(WorkKind(row.kind), int(row.id)) for row in rows]
    found = items_of(connection, wanted)
    return WorkPage(tuple(found[one] for one in wanted if one in found), total)


def items_of(
    connection: Connection, wanted: Collection[tuple[WorkKind, int]]
) -> dict[tuple[WorkKind, int], WorkItem]:
    """Return items by kind and number: one query a kind."""
    numbers: dict[WorkKind, list[int]] = defaultdict(list)
    for kind, number in wanted:
        numbers[kind].append(number)
    queries = [
        SOURCES[kind].items(kind, SOURCES[kind].table.c.id.in_(some)) for kind, some in numbers.items()
    ]
    rows = [row for query in queries for row in connection.execute(query)]
    return {(item.kind, item.id): item for item in map(item_of, rows)}


def _robots() -> Select[Any]:
    serial = func.coalesce(diagnoses.c.robot_serial_number, "")
    return (
        select(
            campaigns.c.robot,
            serial.label("serial_number"),
            func.count(campaigns.c.id.distinct()).label("campaigns"),
            func.count(diagnoses.c.id).label("diagnoses"),
        )
        .outerjoin_from(campaigns, diagnoses, diagnoses.c.campaign_id == campaigns.c.id)
        .group_by(campaigns.c.robot, serial)
        .order_by(func.count(campaigns.c.id).desc(), campaigns.c.robot)
    )
