"""Diagnoses: each stored with the end of its job, with when its readings were taken and of which robot."""

import dataclasses
from datetime import date
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, func, select

from service.domain.diagnosis import Diagnosis
from service.storage.database import Database
from service.storage.documents import from_document, to_document
from service.storage.errors import NotFoundError
from service.storage.jobs import add_job_state
from service.storage.records import DiagnosisRecord, JobState, Page
from service.storage.rows import add_row
from service.storage.tables import campaigns, diagnoses, models, readings, sessions

_LISTED: Final = [column for column in diagnoses.c if column.name not in {"summary", "document"}]


class DiagnosisRepository:
    """All queries about diagnoses."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def keep(self, job_id: int, campaign_id: int, found: Diagnosis, measured_on: date | None) -> int:
        """Store a diagnosis, with its model as a record of its own, and end the job.

        `measured_on` is the day of the readings. Where nobody said it, it is when the session's last
        reading was stored, and of an uploaded campaign when it came.
        """
        document = to_document(dataclasses.replace(found, model=None))
        summary = to_document(without_drawings(found))
        model = None if found.model is None else (found.model.robot.name, to_document(found.model))

        def work(connection: Connection) -> int:
            origin = _Origin(connection, campaign_id)
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
            add_job_state(connection, job_id, JobState.SUCCEEDED, found.message, number)
            return number

        return await self._database.write(work)

    async def get(self, diagnosis_id: int) -> DiagnosisRecord:
        """Return a diagnosis; raises NotFoundError."""
        query = _records(diagnoses.c.document).where(diagnoses.c.id == diagnosis_id)
        row = await self._database.read(lambda c: c.execute(query).one_or_none())
        if row is None:
            raise NotFoundError("diagnosis", diagnosis_id)
        return _record(row)

    async def page(self, page: Page) -> list[DiagnosisRecord]:
        """Return diagnoses without their drawings, oldest first."""
        query = _records(diagnoses.c.summary).where(diagnoses.c.id > page.after)
        ordered = query.order_by(diagnoses.c.id).limit(page.limit)
        return await self._database.read(lambda c: [_record(row) for row in c.execute(ordered)])

    async def newest(self, count: int) -> list[DiagnosisRecord]:
        """Return the latest diagnoses without their drawings, newest first."""
        query = _records(diagnoses.c.summary).order_by(diagnoses.c.id.desc()).limit(count)
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])

    async def of_robot(self, robot: str, serial_number: str | None = None) -> list[DiagnosisRecord]:
        """Return the diagnoses of robots of that name without their drawings, in the order of storing."""
        named = diagnoses.c.summary["robot"].as_string() == robot
        query = _records(diagnoses.c.summary).where(named).order_by(diagnoses.c.id)
        if serial_number is not None:
            query = query.where(diagnoses.c.robot_serial_number == serial_number)
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])


def without_drawings(diagnosis: Diagnosis) -> Diagnosis:
    """Return a diagnosis without curves, single errors and model: what lists and comparisons are made of."""
    left = diagnosis.remaining
    return dataclasses.replace(
        diagnosis,
        findings=tuple(dataclasses.replace(finding, curve=None) for finding in diagnosis.findings),
        remaining=dataclasses.replace(
            left, depends_on=tuple(dataclasses.replace(entry, curve=None) for entry in left.depends_on)
        ),
        errors=None,
        model=None,
    )


class _Origin:
    """Where the readings of a campaign come from, inside the caller's transaction."""

    def __init__(self, connection: Connection, campaign_id: int) -> None:
        query = select(campaigns.c.recorded_at, campaigns.c.session_ids).where(campaigns.c.id == campaign_id)
        self._connection = connection
        self._stored_at, session_ids = connection.execute(query).one()
        self._session_id = session_ids[0] if session_ids else None

    def measured_at(self) -> str:
        last = (
            select(func.max(readings.c.recorded_at))
            .where(readings.c.session_id == self._session_id)
            .where(readings.c.recorded_at <= self._stored_at)  # a running session goes on measuring
        )
        return str(self._connection.scalar(last) or self._stored_at)

    def robot_serial_number(self) -> str:
        query = select(sessions.c.setup).where(sessions.c.id == self._session_id)
        setup = self._connection.scalar(query)
        return "" if setup is None else str(setup["cell"].get("robot_serial_number", ""))


def _records(document: Any) -> Select[Any]:
    return (
        select(
            *_LISTED,
            document.label("told"),
            models.c.id.label("model_id"),
            campaigns.c.session_ids,
        )
        .join(campaigns, campaigns.c.id == diagnoses.c.campaign_id)
        .outerjoin(models, models.c.diagnosis_id == diagnoses.c.id)
    )


def _record(row: Row[Any]) -> DiagnosisRecord:
    return DiagnosisRecord(
        id=row.id,
        recorded_at=row.recorded_at,
        measured_at=row.measured_at,
        job_id=row.job_id,
        campaign_id=row.campaign_id,
        session_id=row.session_ids[0] if row.session_ids else None,
        model_id=row.model_id,
        robot_serial_number=row.robot_serial_number,
        diagnosis=from_document(Diagnosis, row.told),
    )
