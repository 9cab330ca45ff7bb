"""Jobs: what was asked of a worker process and every state the job was in."""

from collections.abc import Iterable
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, Row, ScalarSelect, Select, Table, exists, select

from truepose.messages.message import Text
from truepose.messages.message import message as said
from truepose.storage.database import Database
from truepose.storage.documents import text_from, to_document
from truepose.storage.errors import ConflictError
from truepose.storage.queries import NumberedRecords
from truepose.storage.record_insertion import add_event, add_row, answered_number, once
from truepose.storage.records import JobKind, JobRecord, JobState, JobTaken, RequestKey
from truepose.storage.rows import from_row
from truepose.storage.tables import events, job_states, jobs

PROGRESS = "job.progress"
_STATE = "job.state"


def add_job_state(
    connection: Connection,
    job_id: int,
    state: JobState,
    message: Text,
    result_id: int | None = None,
    code: str | None = None,
) -> None:
    """Append a state and its event in the caller's transaction; raises ConflictError after a final state."""
    # In the writing transaction: of a cancellation and an end that come together only the first counts, so
    # that a job has one final state.
    before = connection.scalar(_state_of(job_id))
    if before is not None and JobState(before).final:
        raise ConflictError(f"Job {job_id} has already {_ENDED[JobState(before)]}.")
    values: dict[str, Any] = {"state": state.value, "message": message, "result_id": result_id}
    add_row(connection, job_states, job_id=job_id, **values)
    add_event(
        connection, _STATE, to_document(values) | ({} if code is None else {"code": code}), job_id=job_id
    )


def add_result(connection: Connection, table: Table, job_id: int, message: Text, **values: Any) -> int:
    """Append a result with the end of its job in the caller's transaction, and return its number."""
    number = add_row(connection, table, job_id=job_id, **values)
    # Result and end of the job are one transaction: a killed service leaves neither a job without its result
    # nor a result that is made once more (decision 0052).
    add_job_state(connection, job_id, JobState.SUCCEEDED, message, number)
    return number


_ENDED = {
    JobState.SUCCEEDED: "succeeded",
    JobState.FAILED: "failed",
    JobState.CANCELLED: "been cancelled",
    JobState.INTERRUPTED: "been interrupted",
}


class JobRepository(NumberedRecords[JobRecord]):
    """All queries about jobs."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "job", jobs, _records, _record)

    async def add(self, kind: JobKind, request: dict[str, Any], key: RequestKey | None = None) -> int:
        """Store a queued job and return its number."""

        def create(connection: Connection) -> int:
            number = add_row(connection, jobs, kind=kind.value, request=request)
            add_job_state(connection, number, JobState.QUEUED, said("job.waiting"))
            return number

        return await self._database.write_new(lambda c: once(c, key, _resource(kind), create))

    async def answered(self, kind: JobKind, key: RequestKey) -> int | None:
        """Return the job that a request with this key queued before; raises KeyReusedError."""
        return await self._database.read(lambda c: answered_number(c, key, _resource(kind)))

    async def interrupt(self, why: Text) -> None:
        """End every job that no final state ended; one whose end is just being written keeps its own."""
        unfinished = job_states.c.state.in_((JobState.QUEUED, JobState.RUNNING))

        def work(connection: Connection) -> None:
            # Looked for and ended in one transaction. Done in two, a job whose end was just being written got
            # a second one, and the stop of the service failed with it (commit a58ddd5f).
            for row in connection.execute(_records().where(unfinished).order_by(jobs.c.id)).all():
                add_job_state(connection, row.id, JobState.INTERRUPTED, why)

        await self._database.write(work)

    async def plans_of(self, session_ids: Iterable[int]) -> dict[int, dict[str, Any]]:
        """Return what was asked of the jobs that planned sessions, by session; given stops had no job."""
        query = (
            select(job_states.c.result_id, jobs.c.request)
            .join(jobs, jobs.c.id == job_states.c.job_id)
            .where(jobs.c.kind == JobKind.PLAN.value, job_states.c.result_id.in_(list(session_ids)))
        )
        return {row.result_id: row.request for row in await self._rows(query)}

    async def taken(self, kind: JobKind, count: int) -> list[JobTaken]:
        """Return how long the latest jobs of a kind took that succeeded and say how much they did."""
        began, ended = job_states.alias("began"), job_states.alias("ended")
        work_count = jobs.c.request["work_count"].as_integer()
        query = (
            select(work_count.label("work_count"), began.c.recorded_at.label("since"), ended.c.recorded_at)
            .join(began, (began.c.job_id == jobs.c.id) & (began.c.state == JobState.RUNNING.value))
            .join(ended, (ended.c.job_id == jobs.c.id) & (ended.c.state == JobState.SUCCEEDED.value))
            .where(jobs.c.kind == kind.value, work_count > 0)  # a plan that was taken over teaches nothing
            .order_by(jobs.c.id.desc())
            .limit(count)
        )
        rows = await self._rows(query)
        return [JobTaken(row.work_count, _between_s(row.since, row.recorded_at)) for row in rows]

    async def change_state(
        self, job_id: int, state: JobState, message: Text, code: str | None = None
    ) -> None:
        """Append a state, with the code of an error; raises ConflictError where the job has ended already."""
        await self._database.write(lambda c: add_job_state(c, job_id, state, message, code=code))

    async def writable(self) -> None:
        """Return once records are taken again; at once where none was refused."""
        await self._database.writable()

    async def tell_progress(self, job_id: int, fraction: float, doing: Text) -> None:
        """Keep how far the job is: `fraction` from 0 to 1."""
        document = to_document({"fraction": fraction, "doing": doing})
        # An event and no state: progress is told far more often than states change.
        await self._database.write(lambda c: add_event(c, PROGRESS, document, job_id=job_id))


def _resource(kind: JobKind) -> str:
    return f"{kind} job"


def _between_s(earlier: str, later: str) -> float:
    return (datetime.fromisoformat(later) - datetime.fromisoformat(earlier)).total_seconds()


def _state_of(job_id: int) -> Select[str]:
    query = select(job_states.c.state).where(job_states.c.job_id == job_id)
    return query.order_by(job_states.c.id.desc()).limit(1)


def _records() -> Select[Any]:
    later = job_states.alias("later")
    newest = ~exists().where(later.c.job_id == jobs.c.id, later.c.id > job_states.c.id)
    return (
        select(
            jobs,
            job_states.c.state,
            job_states.c.message,
            job_states.c.recorded_at.label("state_since"),
            job_states.c.result_id,
            _newest_event(PROGRESS).label("told"),
            _newest_event(_STATE).label("entered"),
        )
        .join(job_states, job_states.c.job_id == jobs.c.id)
        .where(newest)
    )


def _newest_event(kind: str) -> ScalarSelect[Any]:
    query = select(events.c.document).where(events.c.job_id == jobs.c.id, events.c.kind == kind)
    return query.order_by(events.c.id.desc()).limit(1).scalar_subquery()


def _record(row: Row[Any]) -> JobRecord:
    state = JobState(row.state)
    told = row.told or {"fraction": 0.0, "doing": None}
    doing = row.message if told["doing"] is None else text_from(told["doing"])
    return from_row(
        JobRecord,
        row,
        message=doing if state is JobState.RUNNING else row.message,
        fraction=1.0 if state is JobState.SUCCEEDED else told["fraction"],
        code=row.entered.get("code"),
    )
