"""How much there is: counts over all records, for who watches the service."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Select, func, select

from truepose.storage.database import Database
from truepose.storage.dialects import moment_s
from truepose.storage.records import JobState
from truepose.storage.tables import job_states, jobs

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


async def counted(database: Database) -> Counts:
    """Return the counts as of the last commit."""
    return await database.read(_counts)


def _counts(connection: Connection) -> Counts:
    def number(query: str) -> int:
        return int(connection.exec_driver_sql(query).scalar_one())

    def pairs(query: str) -> list[Any]:
        return [tuple(row) for row in connection.exec_driver_sql(query)]

    return Counts(
        sessions=dict(pairs(_BY_STATE.format("session"))),
        jobs=dict(pairs(_BY_STATE.format("job"))),
        job_seconds={kind: (count, seconds) for kind, count, seconds in connection.execute(_job_seconds())},
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
