"""What a database holds as a whole: counts for its observers, and whether it is of a cell or of a plant."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Select, func, select

from truepose.storage.database import Database
from truepose.storage.engine.dialects import moment_s
from truepose.storage.errors import ForeignDatabaseError
from truepose.storage.records import JobState
from truepose.storage.tables import job_states, jobs, metadata

# Numbers of append-only tables are given without gaps, so the newest one is the count.
_NEWEST: Final = "SELECT coalesce(max(id), 0) FROM {}"
_BY_STATE: Final = (
    "SELECT state, count(*) FROM {0}_states WHERE id IN (SELECT max(id) FROM {0}_states GROUP BY {0}_id) "
    "GROUP BY state"
)
_LEGS: Final = "SELECT count(*) FROM session_entries WHERE kind = 'measured' AND reading_id IS NULL"
_LAST_STAMP: Final = "SELECT recorded_at FROM events ORDER BY id DESC LIMIT 1"


@dataclass(frozen=True, slots=True)
class Counts:
    """Counts of one moment."""

    sessions: Mapping[str, int]  # by state
    jobs: Mapping[str, int]  # by state
    job_seconds: Mapping[str, tuple[int, float]]  # by kind: how many have ended, and how long they took
    readings: int
    links: int
    last_stamp: str | None  # of the newest event


async def record_counts(database: Database) -> Counts:
    """Return the counts as of the last commit."""
    return await database.read(_counts)


def _counts(connection: Connection) -> Counts:
    # Plain SQL: the figures are asked for every few seconds by whatever watches the service, and neither
    # engine needs other words for these.
    def number(query: str) -> int:
        return int(connection.exec_driver_sql(query).scalar_one())

    def pairs(query: str) -> list[Any]:
        return [tuple(row) for row in connection.exec_driver_sql(query)]

    return Counts(
        sessions=dict(pairs(_BY_STATE.format("session"))),
        jobs=dict(pairs(_BY_STATE.format("job"))),
        job_seconds={kind: (count, seconds) for kind, count, seconds in connection.execute(_job_seconds())},
        # Lengths and contacts have no row among the readings: the line of the ledger holds them.
        readings=number(_NEWEST.format("readings")) + number(_LEGS),
        links=number(_NEWEST.format("links")),
        last_stamp=connection.exec_driver_sql(_LAST_STAMP).scalar(),
    )


def _job_seconds() -> Select[Any]:
    """Return the query of how many jobs of a kind have ended, and how long they took."""
    begun, ended = job_states.alias("begun"), job_states.alias("ended")
    took_s = func.sum(moment_s(ended.c.recorded_at) - moment_s(begun.c.recorded_at))
    return (
        select(jobs.c.kind, func.count(), took_s)
        .join(begun, (begun.c.job_id == jobs.c.id) & (begun.c.state == JobState.RUNNING.value))
        .join(
            ended,
            (ended.c.job_id == jobs.c.id) & ended.c.state.in_([one.value for one in JobState if one.final]),
        )
        .group_by(jobs.c.kind)
    )


# Jobs, people and acts are in the databases of both; these tables are of one alone.
_OF_CELLS: Final = ("sessions", "campaigns", "series")
_OF_PLANTS: Final = ("plant_cells",)


async def require_of_cell(database: Database) -> None:
    """Raise ForeignDatabaseError for a database with a plant's records and none of a cell."""
    # A database that holds both already is left alone: its one chain has mixed them for good (commit
    # 65876b09).
    if await database.read(lambda c: _has(c, _OF_PLANTS) and not _has(c, _OF_CELLS)):
        raise ForeignDatabaseError(
            f"{database.backend.where} is the database of a plant; start it with 'truepose plant', or choose "
            "another with --database."
        )


async def require_of_plant(database: Database) -> None:
    """Raise ForeignDatabaseError for a database with a cell's records and none of a plant."""
    if await database.read(lambda c: _has(c, _OF_CELLS) and not _has(c, _OF_PLANTS)):
        raise ForeignDatabaseError(
            f"{database.backend.where} is the database of a cell, but a plant needs its own: choose another"
            " with --database."
        )


def _has(connection: Connection, records: tuple[str, ...]) -> bool:
    return any(
        connection.execute(select(metadata.tables[table].c.id).limit(1)).one_or_none() is not None
        for table in records
    )
