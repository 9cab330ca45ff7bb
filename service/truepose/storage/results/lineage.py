"""Lists over all kinds of records, and how one came of others: session, campaign, result, model, proof."""

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from sqlalchemy import Column, Connection, Select, case, cast, func, select, true, union_all

from truepose.storage.engine.dialects import WHOLE, entries_at, number_at
from truepose.storage.queries import Repository
from truepose.storage.records import JobKind
from truepose.storage.results.items import SOURCES, WorkItem, WorkKind, item_of
from truepose.storage.rows import from_row
from truepose.storage.tables import (
    campaigns,
    corrections,
    diagnoses,
    identifications,
    job_states,
    jobs,
    models,
    validations,
)

# What one transaction made may have one moment: an identification comes before its model.
_ORDER: Final = {kind: place for place, kind in enumerate(WorkKind)}


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


class WorkList(Repository):
    """Queries over all kinds of records at once."""

    async def page(
        self, kinds: Collection[WorkKind], texts: Sequence[str] = (), *, skip: int = 0, limit: int = 50
    ) -> WorkPage:
        """Return the records of some kinds in which one of `texts` stands (none: all), newest first."""
        return await self._database.read(lambda c: _page(c, kinds, tuple(texts), skip, limit))

    async def robots(self) -> list[KnownRobot]:
        """Return the robots of which there are campaigns, the busiest first."""
        return await self._each(_robots(), partial(from_row, KnownRobot))


def _page(
    connection: Connection, kinds: Collection[WorkKind], texts: tuple[str, ...], skip: int, limit: int
) -> WorkPage:
    listed = union_all(*(SOURCES[kind].numbers(kind, texts) for kind in kinds)).subquery()
    total = connection.scalar(select(func.count()).select_from(listed)) or 0
    place = case({kind.value: place for kind, place in _ORDER.items()}, value=listed.c.kind)
    newest = select(listed).order_by(listed.c.recorded_at.desc(), place.desc(), listed.c.id.desc())
    # Numbers first, whole items only of the fifty that are shown: one query a kind (decision 0058).
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
            campaigns.c.robot.label("name"),
            serial.label("serial_number"),
            func.count(campaigns.c.id.distinct()).label("campaigns"),
            func.count(diagnoses.c.id).label("diagnoses"),
        )
        .outerjoin_from(campaigns, diagnoses, diagnoses.c.campaign_id == campaigns.c.id)
        .group_by(campaigns.c.robot, serial)
        .order_by(func.count(campaigns.c.id).desc(), campaigns.c.robot)
    )


@dataclass(frozen=True, slots=True)
class Lineage:
    """One record among those it came of and those that came of it, in the order of their making."""

    items: tuple[WorkItem, ...]

    def item(self, kind: WorkKind, number: int) -> WorkItem | None:
        """Return the record of a kind and a number; None where it is not among them."""
        return next((one for one in self.items if (one.kind, one.id) == (kind, number)), None)

    def newest(self, kind: WorkKind, *roles: str) -> WorkItem | None:
        """Return the newest record of a kind, in one of some roles; None where there is none."""
        fitting = (
            one for one in reversed(self.items) if one.kind is kind and (not roles or one.role in roles)
        )
        return next(fitting, None)


class Lineages(Repository):
    """Queries along what came of what."""

    async def of(self, kind: WorkKind, number: int) -> Lineage:
        """Return a record with its forebears and its descendants; the record itself must exist."""
        return await self._database.read(lambda c: _lineage(c, kind, number))


def _lineage(connection: Connection, kind: WorkKind, number: int) -> Lineage:
    family = _Family(connection)
    family.add(kind, number)
    # Back before forth, and never forth from a forebear: the siblings of a record are not of its family.
    family.rise(kind, number)
    family.descend(kind, number)
    items = items_of(connection, family.members)
    return Lineage(tuple(sorted(items.values(), key=lambda one: (one.recorded_at, _ORDER[one.kind], one.id))))


class _Family:
    """Collects records from one of them on, first back and then forth."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self.members: set[tuple[WorkKind, int]] = set()

    def add(self, kind: WorkKind, number: int) -> None:
        self.members.add((kind, number))

    def rise(self, kind: WorkKind, number: int) -> None:
        # Read to the end before going deeper: the next query runs on the same connection.
        for parent in list(self._found(_PARENTS[kind](number))) if kind in _PARENTS else ():
            if parent not in self.members:
                self.add(*parent)
                self.rise(*parent)

    def descend(self, kind: WorkKind, number: int) -> None:
        for query in _CHILDREN.get(kind, ()):
            for child in list(self._found(query(number))):
                if child not in self.members:
                    self.add(*child)
                    self.descend(*child)

    def _found(self, query: Select[Any]) -> Iterable[tuple[WorkKind, int]]:
        for row in self._connection.execute(query).mappings():
            yield from ((WorkKind(kind), number) for kind, number in row.items() if number is not None)


_LISTED = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
_session: Final = cast(_LISTED.c.value, WHOLE)  # of a campaign
_PLANNED: Final = jobs.join(job_states, job_states.c.job_id == jobs.c.id)
_proved: Final = number_at(jobs.c.request, "$.proves_model_id")  # model that a session was planned to prove


def _sessions_of(campaign: int) -> Select[Any]:
    found = select(_session.label("session")).select_from(campaigns.join(_LISTED, true()))
    return found.where(campaigns.c.id == campaign)


def _campaigns_of(session: int) -> Select[Any]:
    found = select(campaigns.c.id.label("campaign")).select_from(campaigns.join(_LISTED, true()))
    return found.where(_session == session)


def _proved_by(session: int) -> Select[Any]:
    found = select(_proved.label("model")).select_from(_PLANNED)
    return found.where(jobs.c.kind == JobKind.PLAN.value, job_states.c.result_id == session)


def _proofs_of(model: int) -> Select[Any]:
    found = select(job_states.c.result_id.label("session")).select_from(_PLANNED)
    return found.where(jobs.c.kind == JobKind.PLAN.value, _proved == model)


_identified: Final = (  # the identification that was made last of the campaign of a diagnosis, before it
    select(func.max(identifications.c.id))
    .where(
        identifications.c.campaign_id == diagnoses.c.campaign_id,
        identifications.c.recorded_at <= diagnoses.c.recorded_at,
    )
    .correlate(diagnoses)
    .scalar_subquery()
)


def _origin_of_diagnosis(number: int) -> Select[Any]:
    found = diagnoses.c.campaign_id.label("campaign"), _identified.label("identification")
    return select(*found).where(diagnoses.c.id == number)


def _diagnoses_after(identification: int) -> Select[Any]:
    return select(diagnoses.c.id.label("diagnosis")).where(_identified == identification)


def _origin_of_model(number: int) -> Select[Any]:
    made_by = models.c.identification_id.label("identification"), models.c.diagnosis_id.label("diagnosis")
    return select(*made_by).where(models.c.id == number)


def _related(kind: WorkKind, column: Column[int], own: Column[int]) -> Callable[[int], Select[Any]]:
    """Return what makes the query of records of a kind, which `column` has where `own` is a number."""
    return lambda number: select(column.label(kind.value)).where(own == number)


_PARENTS = {
    WorkKind.SESSION: _proved_by,
    WorkKind.CAMPAIGN: _sessions_of,
    WorkKind.IDENTIFICATION: _related(WorkKind.CAMPAIGN, identifications.c.campaign_id, identifications.c.id),
    WorkKind.DIAGNOSIS: _origin_of_diagnosis,
    WorkKind.MODEL: _origin_of_model,
    WorkKind.VALIDATION: _related(WorkKind.MODEL, validations.c.model_id, validations.c.id),
    WorkKind.CORRECTION: _related(WorkKind.MODEL, corrections.c.model_id, corrections.c.id),
}
_CHILDREN = {
    WorkKind.SESSION: (_campaigns_of,),
    WorkKind.CAMPAIGN: (
        _related(WorkKind.IDENTIFICATION, identifications.c.id, identifications.c.campaign_id),
        _related(WorkKind.DIAGNOSIS, diagnoses.c.id, diagnoses.c.campaign_id),
    ),
    WorkKind.IDENTIFICATION: (
        _related(WorkKind.MODEL, models.c.id, models.c.identification_id),
        _diagnoses_after,
    ),
    WorkKind.DIAGNOSIS: (_related(WorkKind.MODEL, models.c.id, models.c.diagnosis_id),),
    WorkKind.MODEL: (
        _related(WorkKind.VALIDATION, validations.c.id, validations.c.model_id),
        _related(WorkKind.CORRECTION, corrections.c.id, corrections.c.model_id),
        _proofs_of,
    ),
}
