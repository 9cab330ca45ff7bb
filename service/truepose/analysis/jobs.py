"""Jobs: queued, run one after the other in a worker process, their results stored with their end."""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from datetime import date
from typing import Any, Final, Protocol

from truepose.analysis.errors import BusyError
from truepose.analysis.workers.correcting import CorrectFileTask, FileCorrected, TargetsFile
from truepose.analysis.workers.process import Told, perform_in_worker
from truepose.analysis.workers.tasks import (
    Answer,
    DiagnoseTask,
    IdentifyTask,
    SessionPlanTask,
    Task,
    ValidateTask,
)
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.errors import TrueposeError
from truepose.domain.results import Identification, Validation
from truepose.domain.session import SessionPlan
from truepose.storage.calibration.campaigns import CampaignRepository
from truepose.storage.calibration.corrections import CorrectionRepository, NewCorrection
from truepose.storage.calibration.diagnoses import DiagnosisRepository
from truepose.storage.calibration.jobs import JobRepository
from truepose.storage.calibration.results import ResultRepository
from truepose.storage.records import JobKind, JobState, RequestKey

_MOST_FILES: Final = 4  # of 16 MB at most each
_LOG: Final = logging.getLogger(__name__)


class Perform(Protocol):
    """Performs a task somewhere else; cancelling it stops the work."""

    async def __call__(self, task: Task, told: Told) -> Answer:
        """Return the answer; raises TaskRefusedError or WorkerDiedError."""
        ...


Load = Callable[[], Awaitable[Task]]
Store = Callable[[int, Any], Awaitable[int]]


@dataclass(frozen=True, slots=True)
class _Work:
    load: Load
    store: Store


class JobDesk:
    """Takes jobs and sees them to their end; one at a time, since a running session needs the other core."""

    def __init__(
        self,
        jobs: JobRepository,
        campaigns: CampaignRepository,
        results: ResultRepository,
        diagnoses: DiagnosisRepository,
        corrections: CorrectionRepository,
        perform: Perform = perform_in_worker,
    ) -> None:
        self._jobs = jobs
        self._campaigns = campaigns
        self._results = results
        self._diagnoses = diagnoses
        self._corrections = corrections
        self._perform = perform
        self._turn = asyncio.Lock()
        self._running: dict[int, asyncio.Task[None]] = {}
        self._files: set[int] = set()  # jobs that hold a file in memory

    async def mark_interrupted(self, why: str) -> None:
        """Give every job that has no end one: nobody works on it any more."""
        await self._jobs.interrupt(why)

    async def identify(
        self, campaign_id: int, effects: tuple[str, ...] | None, key: RequestKey | None = None
    ) -> int:
        """Queue an identification and return the job's number; raises NotFoundError."""
        await self._campaigns.get(campaign_id)

        async def load() -> Task:
            return IdentifyTask(await self._campaigns.content(campaign_id), effects)

        async def store(job_id: int, found: Identification) -> int:
            return await self._results.keep_identification(job_id, campaign_id, found)

        request = {"campaign_id": campaign_id, "effects": None if effects is None else list(effects)}
        return await self._queue(JobKind.IDENTIFICATION, request, _Work(load, store), key)

    async def validate(
        self, model_id: int, campaign_id: int, limit_mm: float | None, key: RequestKey | None = None
    ) -> int:
        """Queue a validation and return the job's number; raises NotFoundError."""
        model = (await self._results.model(model_id)).model
        await self._campaigns.get(campaign_id)

        async def load() -> Task:
            return ValidateTask(await self._campaigns.content(campaign_id), model, limit_mm)

        async def store(job_id: int, found: Validation) -> int:
            return await self._results.keep_validation(job_id, model_id, campaign_id, found)

        request = {"model_id": model_id, "campaign_id": campaign_id, "limit_mm": limit_mm}
        return await self._queue(JobKind.VALIDATION, request, _Work(load, store), key)

    async def diagnose(
        self,
        campaign_id: int,
        effects: tuple[str, ...] | None,
        measured_on: date | None = None,
        key: RequestKey | None = None,
    ) -> int:
        """Queue a diagnosis and return the job's number; raises NotFoundError."""
        await self._campaigns.get(campaign_id)

        async def load() -> Task:
            return DiagnoseTask(await self._campaigns.content(campaign_id), effects)

        async def store(job_id: int, found: Diagnosis) -> int:
            return await self._diagnoses.keep(job_id, campaign_id, found, measured_on)

        request = {
            "campaign_id": campaign_id,
            "effects": None if effects is None else list(effects),
            "measured_on": None if measured_on is None else measured_on.isoformat(),
        }
        return await self._queue(JobKind.DIAGNOSIS, request, _Work(load, store), key)

    async def plan(
        self, name: str, task: SessionPlanTask, key: RequestKey | None = None, proved_id: int | None = None
    ) -> int:
        """Queue the choice of a session's configurations and return the job's number."""

        async def load() -> Task:
            return task

        async def store(job_id: int, plan: SessionPlan) -> int:
            return await self._results.keep_plan(job_id, name, task.setup, plan)

        request: dict[str, Any] = {
            "name": name,
            "role": task.template.role,
            **task.asked,
        }
        if proved_id is not None:
            request["proves_model_id"] = proved_id
        return await self._queue(JobKind.PLAN, request, _Work(load, store), key)

    async def correct(
        self, model_id: int, file: TargetsFile, asked: dict[str, Any], key: RequestKey | None = None
    ) -> int:
        """Queue the correction of a file and return the job's number; `asked` is what a record says of it.

        Raises
        ------
        BusyError
            Too many files wait already.
        """

        async def load() -> Task:
            return CorrectFileTask(file)

        async def store(job_id: int, found: FileCorrected) -> int:
            made = NewCorrection(
                file.name,
                found.original_sha256,
                found.corrected_sha256,
                asked,
                found.correction,
                found.targets,
                found.file,
            )
            return await self._corrections.keep(job_id, model_id, made)

        self.require_room()
        request = {"model_id": model_id, "file": file.name, **asked}
        number = await self._queue(JobKind.CORRECTION, request, _Work(load, store), key)
        self._files = {job for job in (*self._files, number) if job in self._running}
        return number

    def require_room(self) -> None:
        """Refuse a file to correct where too many wait in memory already; raises BusyError."""
        if len(self._files & self._running.keys()) >= _MOST_FILES:
            raise BusyError("Too many files wait to be corrected; nothing was stored, ask again later.")

    async def cancel(self, job_id: int) -> None:
        """End a job and its worker; raises NotFoundError, or ConflictError where it has ended already."""
        await self._jobs.get(job_id)
        await self._stop(job_id)
        await self._jobs.change_state(job_id, JobState.CANCELLED, "Cancelled on request; nothing was stored.")

    async def close(self) -> None:
        """End all workers and say so in the records of their jobs."""
        for job_id in list(self._running):
            await self._stop(job_id)
        await self.mark_interrupted("The service was stopped before the job ended; start it again.")

    async def _queue(
        self, kind: JobKind, request: dict[str, Any], work: _Work, key: RequestKey | None
    ) -> int:
        job_id = await self._jobs.add(kind, request, key)
        ended = (await self._jobs.get(job_id)).state.final
        if not ended and job_id not in self._running:  # else: a request that was sent twice
            task = asyncio.create_task(self._run(job_id, work), name=f"job {job_id}")
            self._running[job_id] = task
            task.add_done_callback(lambda _: self._running.pop(job_id, None))
        return job_id

    async def _stop(self, job_id: int) -> None:
        task = self._running.get(job_id)
        if task is not None:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def _run(self, job_id: int, work: _Work) -> None:
        async with self._turn:
            await self._jobs.change_state(job_id, JobState.RUNNING, "A worker process is starting.")
            try:
                answer = await self._perform(await work.load(), self._told(job_id))
                await work.store(job_id, answer)
            except TrueposeError as error:
                await self._jobs.change_state(job_id, JobState.FAILED, str(error))
            except Exception as error:
                # Whatever it is, the job must not look as if somebody still worked on it.
                _LOG.exception("job %d failed", job_id)
                sentence = f"The program failed ({type(error).__name__}: {error}); its log has the details."
                await self._jobs.change_state(job_id, JobState.FAILED, sentence)

    def _told(self, job_id: int) -> Told:
        async def told(fraction: float, doing: str) -> None:
            await self._jobs.tell_progress(job_id, min(max(fraction, 0.0), 1.0), doing)

        return told
