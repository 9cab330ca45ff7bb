"""Corrected files: each stored with the end of its job."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from sqlalchemy import Column, Connection, Row, Select, func, select

from truepose.domain.correction import CorrectedTargets, FileCorrection
from truepose.messages.message import message as said
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document, unpack
from truepose.storage.errors import NotFoundError
from truepose.storage.queries import NumberedRecords, Part
from truepose.storage.record_insertion import add_row
from truepose.storage.records import CorrectionRecord, JobState, Page
from truepose.storage.results.campaigns import simulated_campaign
from truepose.storage.results.jobs import add_job_state
from truepose.storage.tables import campaigns, corrections, diagnoses, identifications, models

T = TypeVar("T")
_LISTED: Final = [column for column in corrections.c if column.name not in {"targets", "file"}]


@dataclass(frozen=True, slots=True)
class NewCorrection:
    """A correction to store."""

    name: str
    original_sha256: str
    corrected_sha256: str
    asked: dict[str, Any]
    correction: FileCorrection
    targets: bytes  # as `documents.pack` packs them
    file: bytes


class CorrectionRepository(NumberedRecords[CorrectionRecord]):
    """All queries about corrections; a record is what is known of one without its targets and its file."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "correction", corrections, _records, _record)

    async def keep(self, job_id: int, model_id: int, made: NewCorrection) -> int:
        """Store a correction and end the job."""
        document, totals = to_document(made.correction), made.correction.totals
        message = said("job.corrected", solved=totals.solved, targets=totals.targets)

        def work(connection: Connection) -> int:
            number = add_row(
                connection,
                corrections,
                job_id=job_id,
                model_id=model_id,
                name=made.name,
                original_sha256=made.original_sha256,
                corrected_sha256=made.corrected_sha256,
                asked=made.asked,
                document=document,
                targets=made.targets,
                file=made.file,
            )
            add_job_state(connection, job_id, JobState.SUCCEEDED, message, number)
            return number

        # Not `write_new`: the job began while there was room, and its end must not be lost for want of it.
        return await self._database.write(work)

    async def newest_of(self, count: int, month: str) -> list[CorrectionRecord]:
        """Return the latest corrections of a month (`2026-11`), or of all where it is empty, newest first."""
        return await self.newest(count, corrections.c.recorded_at.startswith(month))

    async def of_model(self, model_id: int, page: Page) -> Part[CorrectionRecord]:
        """Return the corrections by a model, oldest first."""
        return await self.page(page, corrections.c.model_id == model_id)

    async def file(self, correction_id: int) -> bytes:
        """Return the corrected file; raises NotFoundError."""
        return await self._content(corrections.c.file, correction_id, bytes)

    async def targets(self, correction_id: int) -> CorrectedTargets:
        """Return the targets; raises NotFoundError."""
        return await self._content(
            corrections.c.targets, correction_id, lambda data: unpack(CorrectedTargets, data)
        )

    async def _content(self, column: Column[bytes], correction_id: int, read: Callable[[bytes], T]) -> T:
        query = select(column).where(corrections.c.id == correction_id)

        def work(connection: Connection) -> T:
            found = connection.scalar(query)
            if found is None:
                raise NotFoundError("correction", correction_id)
            return read(found)

        return await self._database.read(work)


def _records() -> Select[Any]:
    made_from = func.coalesce(identifications.c.campaign_id, diagnoses.c.campaign_id)
    return (
        select(*_LISTED, models.c.robot, simulated_campaign())
        .join(models, models.c.id == corrections.c.model_id)
        .outerjoin(identifications, identifications.c.id == models.c.identification_id)
        .outerjoin(diagnoses, diagnoses.c.id == models.c.diagnosis_id)
        # A model that was handed down has no campaign here.
        .outerjoin(campaigns, campaigns.c.id == made_from)
    )


def _record(row: Row[Any]) -> CorrectionRecord:
    return CorrectionRecord(
        id=row.id,
        recorded_at=row.recorded_at,
        job_id=row.job_id,
        model_id=row.model_id,
        robot=row.robot,
        simulated=bool(row.simulated),
        name=row.name,
        original_sha256=row.original_sha256,
        corrected_sha256=row.corrected_sha256,
        asked=row.asked,
        correction=from_document(FileCorrection, row.document),
    )
