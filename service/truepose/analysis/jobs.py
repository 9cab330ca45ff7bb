"""Jobs: what may be asked of a worker process, refused at once where it cannot be answered."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from datetime import date
from typing import Any, Final

from truepose.analysis.errors import BusyError, NothingMeasuredError
from truepose.analysis.job_queue.file_tasks import CorrectFileTask, FileCorrected, TargetsFile
from truepose.analysis.job_queue.queue import JobForecast, JobQueue, Work
from truepose.analysis.job_queue.supervisor import Perform, perform_in_worker
from truepose.analysis.job_queue.tasks import (
    BallbarPlanTask,
    ContactPlanTask,
    DiagnoseTask,
    IdentifyTask,
    RepeatTask,
    SessionPlanTask,
    Task,
    ValidateTask,
    stored_campaign,
)
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.campaign import ReadingsSetAside
from truepose.domain.contacts import ContactPlan
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.errors import RecordRefusedError
from truepose.domain.identification import Identification
from truepose.domain.session import SessionPlan
from truepose.domain.set_aside import found_in
from truepose.domain.validation import Validation
from truepose.messages.message import Text, message
from truepose.storage.documents import to_document
from truepose.storage.records import CampaignRecord, JobKind, JobState, RequestKey
from truepose.storage.results.campaigns import CampaignRepository
from truepose.storage.results.corrections import CorrectionRepository, NewCorrection
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.models import ResultRepository

CheckPlan = Callable[[Any], Awaitable[Text]]  # of the plan that its task makes
_LOG: Final = logging.getLogger(__name__)
_MOST_FILES: Final = 4  # of 16 MB at most each
_PLANNED_BY: Final = {
    SessionPlan: JobKind.PLAN,
    BallbarPlan: JobKind.BALLBAR_PLAN,
    ContactPlan: JobKind.CONTACT_PLAN,
}


class JobService:
    """Takes jobs, refuses those that are known to fail, and queues the others."""

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
        self._queue = JobQueue(jobs, perform)
        self._files: set[int] = set()  # jobs that hold a file in memory

    async def mark_interrupted(self, why: Text) -> None:
        """Give every job that has no end one: nobody works on it any more."""
        await self._jobs.interrupt(why)

    async def identify(
        self,
        campaign_id: int,
        effects: tuple[str, ...] | None,
        key: RequestKey | None = None,
        sender: str = "",
        *,
        set_aside: ReadingsSetAside | None = None,
    ) -> int:
        """Queue an identification and return the job's number.

        Raises NotFoundError, and ConfigurationError where readings cannot be set aside.
        """
        # Before it is queued: nobody should wait for a worker to be told what is known now (decision 0052).
        work_count = _calibration_readings(await self._campaigns.get(campaign_id))
        aside = await self._found(campaign_id, set_aside)

        # Read when the job has its worker: two hundred may wait, each with a campaign of megabytes.
        async def load() -> Task:
            return IdentifyTask(await self._campaigns.content(campaign_id), effects, aside)

        async def store(job_id: int, found: Identification) -> int:
            return await self._results.keep_identification(job_id, campaign_id, found)

        request = {
            "campaign_id": campaign_id,
            "effects": None if effects is None else list(effects),
            "set_aside": to_document(aside),
        }
        work = Work(JobKind.IDENTIFICATION, request, work_count, load, store)
        return await self._queue.add(work, key, sender)

    async def validate(
        self,
        model_id: int,
        campaign_id: int,
        limit_mm: float | None,
        key: RequestKey | None = None,
        sender: str = "",
    ) -> int:
        """Queue a validation and return the job's number; raises NotFoundError."""
        model = (await self._results.model(model_id)).model
        work_count = _validation_readings(await self._campaigns.get(campaign_id))

        async def load() -> Task:
            return ValidateTask(await self._campaigns.content(campaign_id), model, limit_mm)

        async def store(job_id: int, found: Validation) -> int:
            return await self._results.keep_validation(job_id, model_id, campaign_id, found)

        request = {"model_id": model_id, "campaign_id": campaign_id, "limit_mm": limit_mm}
        work = Work(JobKind.VALIDATION, request, work_count, load, store)
        return await self._queue.add(work, key, sender)

    async def diagnose(
        self,
        campaign_id: int,
        effects: tuple[str, ...] | None,
        measured_on: date | None = None,
        key: RequestKey | None = None,
        sender: str = "",
        *,
        set_aside: ReadingsSetAside | None = None,
    ) -> int:
        """Queue a diagnosis and return the job's number; raises as `identify`."""
        work_count = _calibration_readings(await self._campaigns.get(campaign_id))
        aside = await self._found(campaign_id, set_aside)

        async def load() -> Task:
            return DiagnoseTask(await self._campaigns.content(campaign_id), effects, aside)

        async def store(job_id: int, found: Diagnosis) -> int:
            return await self._diagnoses.keep(job_id, campaign_id, found, measured_on)

        request = {
            "campaign_id": campaign_id,
            "effects": None if effects is None else list(effects),
            "measured_on": None if measured_on is None else measured_on.isoformat(),
            "set_aside": to_document(aside),
        }
        work = Work(JobKind.DIAGNOSIS, request, work_count, load, store)
        return await self._queue.add(work, key, sender)

    async def _found(self, campaign_id: int, wanted: ReadingsSetAside | None) -> ReadingsSetAside | None:
        """Return readings to set aside as they are in a campaign; raises ConfigurationError."""
        if wanted is None:
            return None
        content = await self._campaigns.content(campaign_id)
        return await asyncio.to_thread(lambda: found_in(stored_campaign(content), wanted))

    async def plan(
        self,
        name: str,
        task: SessionPlanTask,
        key: RequestKey | None = None,
        proved_id: int | None = None,
        sender: str = "",
    ) -> int:
        """Queue the choice of a session's configurations and return the job's number."""
        request: dict[str, Any] = {
            "name": name,
            "role": task.template.role,
            **task.asked,
        }
        if proved_id is not None:
            request["proves_model_id"] = proved_id
        return await self._plan(JobKind.PLAN, request, task, _chosen_clear, key, sender)

    async def plan_checked(
        self,
        name: str,
        task: BallbarPlanTask | ContactPlanTask,
        check: CheckPlan,
        key: RequestKey | None = None,
        sender: str = "",
    ) -> int:
        """Queue the choice of a session's poses or stops and return the job's number.

        `check` returns what to watch in what was chosen. It raises where the cell cannot do that; the job
        then fails with that sentence.
        """
        of_bar = isinstance(task, BallbarPlanTask)
        request = {"name": name, "role": "ballbar" if of_bar else "contacts", **task.asked}
        kind = JobKind.BALLBAR_PLAN if of_bar else JobKind.CONTACT_PLAN
        return await self._plan(kind, request, task, check, key, sender)

    async def repeat(
        self,
        name: str,
        task: RepeatTask,
        check: CheckPlan,
        key: RequestKey | None = None,
        sender: str = "",
    ) -> int:
        """Queue a session with the plan of an earlier one and return the job's number; `check` as above."""
        request = {**task.asked, "name": name}
        return await self._plan(_PLANNED_BY[type(task.plan)], request, task, check, key, sender)

    async def _plan(
        self,
        kind: JobKind,
        request: dict[str, Any],
        task: SessionPlanTask | BallbarPlanTask | ContactPlanTask | RepeatTask,
        check: CheckPlan,
        key: RequestKey | None,
        sender: str,
    ) -> int:
        """Queue what makes the plan of a session, whose name is in the request."""

        async def load() -> Task:
            return task

        async def store(job_id: int, plan: SessionPlan | BallbarPlan | ContactPlan) -> int:
            notice = await check(plan)
            return await self._results.keep_plan(job_id, request["name"], task.setup, plan, notice)

        return await self._queue.add(Work(kind, request, task.work_count, load, store), key, sender)

    async def correct(
        self,
        model_id: int,
        file: TargetsFile,
        asked: dict[str, Any],
        key: RequestKey | None = None,
        sender: str = "",
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

        if not await self._queue.knows(JobKind.CORRECTION, key):
            self.require_room()
        request = {"model_id": model_id, "file": file.name, **asked}
        work = Work(JobKind.CORRECTION, request, len(file.data) // 1024, load, store)
        number = await self._queue.add(work, key, sender)
        # A file lies in memory until its job ends. Those that have ended are forgotten when the next one
        # comes.
        self._files = {job for job in (*self._files, number) if self._queue.under_way(job)}
        return number

    def require_room(self) -> None:
        """Refuse a file to correct where too many wait in memory already; raises BusyError."""
        if sum(map(self._queue.under_way, self._files)) >= _MOST_FILES:
            raise BusyError(message("refused.many_files"))

    async def cancel(self, job_id: int) -> None:
        """End a job and its worker.

        Raises NotFoundError, ConflictError where it has ended already, and RecordRefusedError where its end
        cannot be put on record; then it goes on.
        """
        await self._jobs.get(job_id)
        # On record first. Where storage refuses the end, the job goes on: a worker that was killed for an end
        # that nobody kept would leave a job that runs for ever.
        await self._jobs.change_state(job_id, JobState.CANCELLED, message("job.cancelled_on_request"))
        await self._queue.stop(job_id)

    def foreseen(self, job_id: int) -> JobForecast | None:
        """Return what is known of a job that has not ended; None of others."""
        return self._queue.foreseen(job_id)

    async def close(self) -> None:
        """End all workers and say so in the records of their jobs."""
        await self._queue.close()
        try:
            await self.mark_interrupted(message("job.service_stopped"))
        except RecordRefusedError as error:  # the next service finds them and says so itself
            _LOG.warning("running jobs could not be recorded as interrupted: %s", error)


async def _chosen_clear(plan: SessionPlan) -> str:
    return ""  # the chooser keeps the ways clear


def _calibration_readings(campaign: CampaignRecord) -> int:
    """Return how many readings can identify; raises NothingMeasuredError where none can."""
    held = campaign.summary
    found = held.calibration_points + held.calibration_legs + held.calibration_contacts
    if not found:
        raise NothingMeasuredError(message("refused.no_calibration", campaign=campaign.id))
    return found


def _validation_readings(campaign: CampaignRecord) -> int:
    """Return how many readings can judge a model; raises NothingMeasuredError where none can."""
    held = campaign.summary
    found = held.validation_points + held.validation_legs + held.validation_contacts
    if not found:
        raise NothingMeasuredError(message("refused.no_validation", campaign=campaign.id))
    return found
