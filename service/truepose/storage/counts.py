"""How much there is: counts over all records, for who watches the service."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection

from truepose.storage.database import Database

# Numbers of append-only tables are given without gaps, so the newest one is the count.
_NEWEST: Final = "SELECT coalesce(max(id), 0) FROM {}"
_BY_STATE: Final = (
    "SELECT state, count(*) FROM {0}_states WHERE id IN (SELECT max(id) FROM {0}_states GROUP BY {0}_id) "
    "GROUP BY state"
)
_LEGS: Final = "SELECT count(*) FROM session_entries WHERE kind = 'measured' AND reading_id IS NULL"
_JOB_SECONDS: Final = """
    SELECT jobs.kind, count(*), sum(86400 * (julianday(ended.recorded_at) - julianday(begun.recorded_at)))
    FROM jobs
    JOIN job_states AS begun ON begun.job_id = jobs.id AND begun.state = 'running'
    JOIN job_states AS ended ON ended.job_id = jobs.id
        AND ended.state IN ('succeeded', 'failed', 'cancelled', 'interrupted')
    GROUP BY jobs.kind
"""
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
        job_seconds={kind: (count, seconds) for kind, count, seconds in pairs(_JOB_SECONDS)},
        readings=number(_NEWEST.format("readings")) + number(_LEGS),
        links=number(_NEWEST.format("links")),
        last_stamp=connection.exec_driver_sql(_LAST_STAMP).scalar(),
    )
