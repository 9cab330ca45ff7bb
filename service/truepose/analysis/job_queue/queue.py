"""Jobs under way: given a place, told how far they are, ended on request, their end always on record.

What a worker has found waits in memory where storage refuses it, and so does any end of a job: it is written
once records are taken again. A result that alone is refused, while others are taken, has its job fail.
"""

import asyncio
import contextlib
import itertools
import logging
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final

from truepose.analysis.errors import BusyError
from truepose.analysis.job_queue.scheduling import REMEMBERED, Outlook, WorkerSlots, expected_s, outlook
from truepose.analysis.job_queue.supervisor import Perform, Told
from truepose.analysis.job_queue.tasks import Task
from truepose.domain.errors import RecordRefusedError, TrueposeError
from truepose.messages.error_codes import code_of
from truepose.messages.message import Text, message
from truepose.storage.errors import ConflictError
from truepose.storage.records import JobKind, JobState, RequestKey
from truepose.storage.results.jobs import JobRepository

_MOST_WAITING: Final = 200  # each a few kilobytes; more are a script that has run away
_TRIES: Final = 240  # to keep a result while other records are taken: a minute at least
_AGAIN_S: Final = 0.25
_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Work:
    """What a job does: its task is loaded when it has a place, its answer stored with its end."""

    kind: JobKind
    request: dict[str, Any]  # as it is kept
    work_count: int  # readings, configurations, poses, or kilobytes of a file
    load: Callable[[], Awaitable[Task]]
    store: Callable[[int, Any], Awaitable[int]]


@dataclass(frozen=True, slots=True)
class JobForecast:
    """What is known of a job that has not ended."""

    ahead_count: int  # jobs that are given a place before it
    outlook: Outlook | None  # None: it waits
    refused: Text | None = None  # why its next state, or its result, waits in memory


@dataclass(slots=True)
class _Job:
    expected_s: float
    began_s: float | None = None
    told: float = 0.0
    told_at_s: float = 0.0
    fraction: float = 0.0  # that was shown; less is never shown again
    refused: Text | None = None  # by storage; None: what it wrote is on record


class JobQueue:
    """Sees jobs to their end, each in a place of its own."""

    def __init__(
        self, jobs: JobRepository, perform: Perform, now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._jobs = jobs
        self._perform = perform
        self._now_s = now_s
        self._places = WorkerSlots()
        self._running: dict[int, asyncio.Task[None]] = {}
        self._known: dict[int, _Job] = {}

    def under_way(self, job_id: int) -> bool:
        """Whether a job waits or runs."""
        return job_id in self._running

    def foreseen(self, job_id: int) -> JobForecast | None:
        """Return what is known of a job under way; None where it is not."""
        job = self._known.get(job_id)
        if job is None:
            return None
        return JobForecast(self._places.ahead(job_id), self._outlook(job), job.refused)

    async def add(self, work: Work, key: RequestKey | None, sender: str = "") -> int:
        """Queue a job and return its number; that of a request that was sent twice is the first one's.

        Raises
        ------
        BusyError
            Too many wait already.
        """
        if len(self._running) >= _MOST_WAITING and not await self.knows(work.kind, key):
            raise BusyError(message("refused.many_jobs", most=_MOST_WAITING))
        request = {**work.request, "work_count": work.work_count}
        earlier = await self._jobs.taken(work.kind, REMEMBERED)
        job_id = await self._jobs.add(work.kind, request, key)
        # A request that was sent twice finds the first one's job, which waits, runs, or has ended. Begun once
        # more, it would be computed twice and its second end refused.
        ended = key is not None and (await self._jobs.get(job_id)).state.final
        if not ended and job_id not in self._running:
            self._begin(job_id, work, expected_s(work.kind, work.work_count, earlier), sender)
        return job_id

    async def knows(self, kind: JobKind, key: RequestKey | None) -> bool:
        """Whether a request was sent before: it has its job, and needs no room. Raises KeyReusedError."""
        return key is not None and await self._jobs.answered(kind, key) is not None

    async def stop(self, job_id: int) -> None:
        """End a job's worker, if it has one, and take it out of the queue."""
        task = self._running.get(job_id)
        if task is not None:
            # Awaited: the worker and its children are gone before whoever stopped the job is answered
            # (decision 0052).
            task.cancel()
            await asyncio.wait({task})

    async def close(self) -> None:
        """End all workers."""
        for job_id in list(self._running):
            await self.stop(job_id)

    def _begin(self, job_id: int, work: Work, expected: float, sender: str) -> None:
        self._known[job_id] = _Job(expected)
        task = asyncio.create_task(self._run(job_id, work, sender), name=f"job {job_id}")
        self._running[job_id] = task
        # Of a job that has ended the record says all there is to know; in memory are only those under way.
        task.add_done_callback(lambda _: self._forget(job_id))

    def _forget(self, job_id: int) -> None:
        del self._running[job_id], self._known[job_id]

    async def _run(self, job_id: int, work: Work, sender: str) -> None:
        job = self._known[job_id]
        async with self._places.place(job_id, job.expected_s, sender):
            job.began_s = self._now_s()  # known to whoever reads that it runs
            try:
                await self._end_of(job_id, job, work, job.began_s)
            # A cancellation is on record before the worker is killed. A result that comes in between is too
            # late; it is no fault of the program.
            except ConflictError as error:
                _LOG.info("job %d is already recorded as ended: %s", job_id, error)

    async def _end_of(self, job_id: int, job: _Job, work: Work, began_s: float) -> None:
        """See a job to its end; raises ConflictError where somebody else has put one on record."""
        try:
            starting = (job_id, JobState.RUNNING, message("job.starting"))
            await self._kept(job_id, job, lambda: self._jobs.change_state(*starting))
            answer = await self._perform(await work.load(), self._told(job_id, job, began_s))
            await self._kept(job_id, job, lambda: work.store(job_id, answer), _TRIES)
        except Exception as error:  # whatever it is, nobody works on the job any more
            try:
                await self._fail(job_id, job, error)
            except ConflictError:
                raise
            except Exception as unkept:  # of words, say, that no storage has letters for
                await self._fail(job_id, job, unkept)

    async def _fail(self, job_id: int, job: _Job, error: Exception) -> None:
        failed = (job_id, JobState.FAILED, _said(job_id, error), code_of(error))
        await self._kept(job_id, job, lambda: self._jobs.change_state(*failed))

    async def _kept(
        self, job_id: int, job: _Job, write: Callable[[], Awaitable[object]], tries: int | None = None
    ) -> None:
        """Write, again where storage refuses; raises the refusal after some `tries`, where they count."""
        for count in itertools.count(1):
            try:
                await write()
                break
            except RecordRefusedError as error:
                if count == tries:
                    raise
                # One line for each wait: on a full disk it may be tried for hours.
                if job.refused is None:
                    _LOG.warning("records of job %d wait in memory to be stored: %s", job_id, error)
                job.refused = error.text
            await self._jobs.writable()
            # Storage may take other records and refuse this one still: without a pause this would spin.
            await asyncio.sleep(_AGAIN_S)
        job.refused = None

    def _told(self, job_id: int, job: _Job, began_s: float) -> Told:
        async def told(fraction: float, doing: Text) -> None:
            job.told = min(max(fraction, 0.0), 1.0)
            job.told_at_s = self._now_s() - began_s
            with contextlib.suppress(RecordRefusedError):  # the next one says more
                await self._jobs.tell_progress(job_id, job.told, doing)

        return told

    def _outlook(self, job: _Job) -> Outlook | None:
        if job.began_s is None:
            return None
        now = outlook(job.expected_s, self._now_s() - job.began_s, job.told, job.told_at_s)
        # Estimates change as a job tells more of itself; a bar that runs backwards looks like a fault.
        job.fraction = max(job.fraction, now.fraction)
        return Outlook(job.fraction, now.remaining_s)


def _said(job_id: int, error: Exception) -> Text:
    if isinstance(error, TrueposeError):
        return error.text
    _LOG.error("job %d failed", job_id, exc_info=error)
    return message("job.program_failed", kind=type(error).__name__, why=str(error))
