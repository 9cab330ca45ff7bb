"""How a record came of others, and what came of it: session, campaign, result, model, what the model did."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Select, cast, select, true

from truepose.storage.column_types import WHOLE
from truepose.storage.database import Database
from truepose.storage.dialects import entries_at, number_at
from truepose.storage.records import JobKind
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
from truepose.storage.work.items import WorkItem, WorkKind
from truepose.storage.work.listing import items_of


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


class Lineages:
    """Queries along what came of what."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def of(self, kind: WorkKind, number: int) -> Lineage:
        """Return a record with its forebears and its descendants; the record itself must exist."""
        return await self._database.read(lambda c: _lineage(c, kind, number))


def _lineage(connection: Connection, kind: WorkKind, number: int) -> Lineage:
    family = _Family(connection)
    family.add(kind, number)
    family.rise(kind, number)
    family.descend(kind, number)
    items = items_of(connection, family.members)
    # Moments alone do not order what one transaction made.
    return Lineage(tuple(sorted(items.values(), key=lambda one: (one.recorded_at, _ORDER[one.kind], one.id))))


_ORDER = {kind: place for place, kind in enumerate(WorkKind)}


class _Family:
    """Collects records from one of them on, first back and then forth."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self.members: set[tuple[WorkKind, int]] = set()

    def add(self, kind: WorkKind, number: int) -> None:
        self.members.add((kind, number))

    def rise(self, kind: WorkKind, number: int) -> None:
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


def _sessions_of(campaign: int) -> Select[Any]:
    listed = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
    inside = campaigns.join(listed, true())
    return (
        select(cast(listed.c.value, WHOLE).label("session"))
        .select_from(inside)
        .where(campaigns.c.id == campaign)
    )


def _origin_of(table: Any) -> Any:
    return lambda number: select(table.c.campaign_id.label("campaign")).where(table.c.id == number)


def _origin_of_model(number: int) -> Select[Any]:
    made_by = models.c.identification_id.label("identification"), models.c.diagnosis_id.label("diagnosis")
    return select(*made_by).where(models.c.id == number)


def _model_of(table: Any) -> Any:
    return lambda number: select(table.c.model_id.label("model")).where(table.c.id == number)


def _proved_by(session: int) -> Select[Any]:
    """Return the query of the model that a session was planned to prove."""
    return (
        select(number_at(jobs.c.request, "$.proves_model_id").label("model"))
        .join(job_states, job_states.c.job_id == jobs.c.id)
        .where(jobs.c.kind == JobKind.PLAN.value, job_states.c.result_id == session)
    )


def _campaigns_of(session: int) -> Select[Any]:
    listed = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
    inside = campaigns.join(listed, true())
    return (
        select(campaigns.c.id.label("campaign"))
        .select_from(inside)
        .where(cast(listed.c.value, WHOLE) == session)
    )


def _made_of_campaign(table: Any, kind: WorkKind) -> Any:
    return lambda number: select(table.c.id.label(kind.value)).where(table.c.campaign_id == number)


def _model_made_by(column: Any) -> Any:
    return lambda number: select(models.c.id.label("model")).where(column == number)


def _made_with_model(table: Any, kind: WorkKind) -> Any:
    return lambda number: select(table.c.id.label(kind.value)).where(table.c.model_id == number)


def _proofs_of(model: int) -> Select[Any]:
    return (
        select(job_states.c.result_id.label("session"))
        .join(jobs, jobs.c.id == job_states.c.job_id)
        .where(
            jobs.c.kind == JobKind.PLAN.value,
            number_at(jobs.c.request, "$.proves_model_id") == model,
        )
    )


_PARENTS = {
    WorkKind.SESSION: _proved_by,
    WorkKind.CAMPAIGN: _sessions_of,
    WorkKind.IDENTIFICATION: _origin_of(identifications),
    WorkKind.DIAGNOSIS: _origin_of(diagnoses),
    WorkKind.MODEL: _origin_of_model,
    WorkKind.VALIDATION: _model_of(validations),
    WorkKind.CORRECTION: _model_of(corrections),
}
_CHILDREN = {
    WorkKind.SESSION: (_campaigns_of,),
    WorkKind.CAMPAIGN: (
        _made_of_campaign(identifications, WorkKind.IDENTIFICATION),
        _made_of_campaign(diagnoses, WorkKind.DIAGNOSIS),
    ),
    WorkKind.IDENTIFICATION: (_model_made_by(models.c.identification_id),),
    WorkKind.DIAGNOSIS: (_model_made_by(models.c.diagnosis_id),),
    WorkKind.MODEL: (
        _made_with_model(validations, WorkKind.VALIDATION),
        _made_with_model(corrections, WorkKind.CORRECTION),
        _proofs_of,
    ),
}
