"""Jobs under way: given a place, told how far they are, ended on request, their end always on record."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final

from truepose.analysis.errors import BusyError
from truepose.analysis.workers.durations import REMEMBERED, Outlook, expected_s, outlook
from truepose.analysis.workers.places import Places
from truepose.analysis.workers.process import Perform, Told
from truepose.analysis.workers.tasks import Task
from truepose.domain.errors import TrueposeError
from truepose.storage.calibration.jobs import JobRepository
from truepose.storage.records import JobKind, JobState, RequestKey
from truepose.words.error_codes import code_of

_MOST_WAITING: Final = 200  # each a few kilobytes; more are a script that has run away
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
class Foreseen:
    """What is known of a job that has not ended."""

    ahead_count: int  # jobs that are given a place before it
    outlook: Outlook | None  # None: it waits


@dataclass(slots=True)
class _Job:
    expected_s: float
    began_s: float | None = None
    told: float = 0.0
    told_at_s: float = 0.0
    fraction: float = 0.0  # that was shown; less is never shown again


class JobQueue:
    """Sees jobs to their end, each in a place of its own."""

    def __init__(
        self, jobs: JobRepository, perform: Perform, now_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._jobs = jobs
        self._perform = perform
        self._now_s = now_s
        self._places = Places()
        self._running: dict[int, asyncio.Task[None]] = {}
        self._known: dict[int, _Job] = {}

    def under_way(self, job_id: int) -> bool:
        """Whether a job waits or runs."""
        return job_id in self._running

    def foreseen(self, job_id: int) -> Foreseen | None:
        """Return what is known of a job under way; None where it is not."""
        job = self._known.get(job_id)
        if job is None:
            return None
        return Foreseen(self._places.ahead(job_id), self._outlook(job))

    async def add(self, work: Work, key: RequestKey | None, sender: str = "") -> int:
        """Queue a job and return its number; that of a request that was sent twice is the first one's.

        Raises
        ------
        BusyError
            Too many wait already.
        """
        if len(self._running) >= _MOST_WAITING:
            raise BusyError(f"{_MOST_WAITING} jobs wait already; nothing was stored, ask again later.")
        request = {**work.request, "work_count": work.work_count}
        job_id = await self._jobs.add(work.kind, request, key)
        ended = (await self._jobs.get(job_id)).state.final
        if not ended and job_id not in self._running:
            earlier = await self._jobs.taken(work.kind, REMEMBERED)
            self._begin(job_id, work, expected_s(work.kind, work.work_count, earlier), sender)
        return job_id

    async def stop(self, job_id: int) -> None:
        """End a job's worker, if it has one, and take it out of the queue."""
        task = self._running.get(job_id)
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def close(self) -> None:
        """End all workers."""
        for job_id in list(self._running):
            await self.stop(job_id)

    def _begin(self, job_id: int, work: Work, expected: float, sender: str) -> None:
        self._known[job_id] = _Job(expected)
        task = asyncio.create_task(self._run(job_id, work, sender), name=f"job {job_id}")
        self._running[job_id] = task
        task.add_done_callback(lambda _: self._forget(job_id))

    def _forget(self, job_id: int) -> None:
        del self._running[job_id], self._known[job_id]

    async def _run(self, job_id: int, work: Work, sender: str) -> None:
        job = self._known[job_id]
        async with self._places.place(job_id, job.expected_s, sender):
            job.began_s = self._now_s()  # known to whoever reads that it runs
            await self._jobs.change_state(job_id, JobState.RUNNING, "A worker process is starting.")
            try:
                answer = await self._perform(await work.load(), self._told(job_id, job, job.began_s))
                await work.store(job_id, answer)
            except TrueposeError as error:
                await self._jobs.change_state(job_id, JobState.FAILED, str(error), code_of(error))
            except Exception as error:
                # Whatever it is, the job must not look as if somebody still worked on it.
                _LOG.exception("job %d failed", job_id)
                sentence = f"The program failed ({type(error).__name__}: {error}); its log has the details."
                await self._jobs.change_state(job_id, JobState.FAILED, sentence, code_of(error))

    def _told(self, job_id: int, job: _Job, began_s: float) -> Told:
        async def told(fraction: float, doing: str) -> None:
            job.told = min(max(fraction, 0.0), 1.0)
            job.told_at_s = self._now_s() - began_s
            await self._jobs.tell_progress(job_id, job.told, doing)

        return told

    def _outlook(self, job: _Job) -> Outlook | None:
        if job.began_s is None:
            return None
        now = outlook(job.expected_s, self._now_s() - job.began_s, job.told, job.told_at_s)
        job.fraction = max(job.fraction, now.fraction)
        return Outlook(job.fraction, now.remaining_s)
