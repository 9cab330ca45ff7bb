"""Diagnoses: each stored with the end of its job, with when its readings were taken and of which robot."""

import dataclasses
from datetime import date
from functools import partial
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, select

from truepose.domain.diagnosis import Diagnosis, Finding
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.queries import NumberedRecords
from truepose.storage.record_insertion import add_row
from truepose.storage.records import DiagnosisRecord, JobState
from truepose.storage.results.campaigns import Origin, simulated_campaign
from truepose.storage.results.jobs import add_job_state
from truepose.storage.rows import from_row
from truepose.storage.tables import campaigns, diagnoses, models

_LISTED: Final = [column for column in diagnoses.c if column.name not in {"summary", "document"}]


class DiagnosisRepository(NumberedRecords[DiagnosisRecord]):
    """All queries about diagnoses; only one by its number comes with its drawings."""

    def __init__(self, database: Database) -> None:
        whole, undrawn = partial(_records, diagnoses.c.document), partial(_records, diagnoses.c.summary)
        super().__init__(database, "diagnosis", diagnoses, undrawn, _record)
        self._whole = NumberedRecords(database, "diagnosis", diagnoses, whole, _record)

    async def keep(self, job_id: int, campaign_id: int, found: Diagnosis, measured_on: date | None) -> int:
        """Store a diagnosis, with its model as a record of its own, and end the job.

        `measured_on` is the day of the readings. Else it is the day that the campaign states, or when the
        session's last reading was stored; of an upload that says nothing it stays unknown.
        """
        # Documents are made outside the transaction: a diagnosis has megabytes of curves, and everybody's
        # writes wait for the writer's thread.
        document = to_document(dataclasses.replace(found, model=None))
        # Kept beside the whole document, so that lists and comparisons need not read what only a page draws.
        summary = to_document(without_drawings(found))
        model = None if found.model is None else (found.model.robot.name, to_document(found.model))

        def work(connection: Connection) -> int:
            origin = Origin(connection, campaign_id)
            number = add_row(
                connection,
                diagnoses,
                job_id=job_id,
                campaign_id=campaign_id,
                measured_at=origin.measured_at() if measured_on is None else measured_on.isoformat(),
                robot_serial_number=origin.robot_serial_number(),
                summary=summary,
                document=document,
            )
            if model is not None:
                add_row(connection, models, diagnosis_id=number, robot=model[0], document=model[1])
            # Result and end of the job are one transaction: a killed service leaves neither a job without its
            # result nor a result that is made once more (decision 0052).
            add_job_state(connection, job_id, JobState.SUCCEEDED, found.message, number)
            return number

        return await self._database.write(work)

    async def get(self, number: int) -> DiagnosisRecord:
        """Return a diagnosis with its drawings; raises NotFoundError."""
        return await self._whole.get(number)

    async def newest_of_campaign(self, campaign_id: int) -> DiagnosisRecord | None:
        """Return the latest diagnosis of a campaign without its drawings; None where it has none."""
        found = await self.newest(1, diagnoses.c.campaign_id == campaign_id)
        return found[0] if found else None

    async def of_robot(self, robot: str, serial_number: str | None = None) -> list[DiagnosisRecord]:
        """Return the diagnoses of robots of that name without their drawings, in the order of storing."""
        named = diagnoses.c.summary["robot"].as_string() == robot
        query = _records(diagnoses.c.summary).where(named).order_by(diagnoses.c.id)
        if serial_number is not None:
            query = query.where(diagnoses.c.robot_serial_number == serial_number)
        return await self._each(query, _record)


def without_drawings(diagnosis: Diagnosis) -> Diagnosis:
    """Return a diagnosis without curves, single errors and model: what lists and comparisons are made of."""
    left = diagnosis.remaining
    return dataclasses.replace(
        diagnosis,
        findings=_without_curves(diagnosis.findings),
        small=_without_curves(diagnosis.small),
        remaining=dataclasses.replace(
            left, depends_on=tuple(dataclasses.replace(entry, curve=None) for entry in left.depends_on)
        ),
        errors=None,
        model=None,
    )


def _without_curves(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    return tuple(dataclasses.replace(finding, curve=None, spectrum=None) for finding in findings)


def _records(document: Any) -> Select[Any]:
    return (
        select(
            *_LISTED,
            document.label("told"),
            models.c.id.label("model_id"),
            campaigns.c.session_ids,
            simulated_campaign(),
        )
        .join(campaigns, campaigns.c.id == diagnoses.c.campaign_id)
        .outerjoin(models, models.c.diagnosis_id == diagnoses.c.id)
    )


def _record(row: Row[Any]) -> DiagnosisRecord:
    return from_row(
        DiagnosisRecord,
        row,
        measured_at=row.measured_at or None,
        session_id=row.session_ids[0] if row.session_ids else None,
        diagnosis=from_document(Diagnosis, row.told),
    )
