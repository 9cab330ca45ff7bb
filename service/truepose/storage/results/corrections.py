"""Corrected files: each stored with the end of its job."""

import asyncio
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Row, Select, func, select

from truepose.domain.correction import CorrectedTargets, FileCorrection
from truepose.messages.message import message as said
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document, unpack
from truepose.storage.queries import NumberedRecords, Part
from truepose.storage.records import CorrectionRecord, Page
from truepose.storage.results.campaigns import simulated_campaign
from truepose.storage.results.jobs import add_result
from truepose.storage.rows import from_row, to_row
from truepose.storage.tables import campaigns, corrections, diagnoses, identifications, models

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
        totals = made.correction.totals
        message = said("job.corrected", solved=totals.solved, targets=totals.targets)
        values = {"model_id": model_id, "document": to_document(made.correction), **to_row(made, corrections)}
        # Not `write_new`: the job began while there was room, and its end must not be lost for want of it.
        return await self._database.write(lambda c: add_result(c, corrections, job_id, message, **values))

    async def of_model(self, model_id: int, page: Page) -> Part[CorrectionRecord]:
        """Return the corrections by a model, oldest first."""
        return await self.page(page, corrections.c.model_id == model_id)

    async def file(self, correction_id: int) -> bytes:
        """Return the corrected file; raises NotFoundError."""
        return bytes(await self._content(corrections.c.file, correction_id))

    async def targets(self, correction_id: int) -> CorrectedTargets:
        """Return the targets; raises NotFoundError."""
        packed = await self._content(corrections.c.targets, correction_id)
        # Of a large file unpacking takes long: off the loop.
        return await asyncio.to_thread(unpack, CorrectedTargets, packed)


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
    return from_row(CorrectionRecord, row, correction=from_document(FileCorrection, row.document))
