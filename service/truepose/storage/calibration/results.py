"""What jobs made: identifications, models and validations, each stored with the end of its job."""

import dataclasses
from typing import Any

from sqlalchemy import Connection, Row, Select, func, select

from truepose.domain.results import Identification, Model, Validation
from truepose.domain.session import SessionPlan
from truepose.storage.calibration.jobs import add_job_state
from truepose.storage.calibration.origins import simulated_campaign
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import NotFoundError
from truepose.storage.measurement.sessions import add_session
from truepose.storage.records import (
    IdentificationRecord,
    JobState,
    ModelRecord,
    Page,
    SessionSetup,
    ValidationRecord,
)
from truepose.storage.rows import add_row
from truepose.storage.tables import campaigns, diagnoses, identifications, models, validations
from truepose.words.catalogue import english


class ResultRepository:
    """All queries about results; a result and the end of its job are one transaction."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def keep_identification(self, job_id: int, campaign_id: int, found: Identification) -> int:
        """Store an identification, with its model as a record of its own, and end the job."""
        document = to_document(dataclasses.replace(found, model=None))
        model = None if found.model is None else (found.model.robot.name, to_document(found.model))

        def work(connection: Connection) -> int:
            number = add_row(
                connection, identifications, job_id=job_id, campaign_id=campaign_id, document=document
            )
            if model is not None:
                add_row(connection, models, identification_id=number, robot=model[0], document=model[1])
            add_job_state(connection, job_id, JobState.SUCCEEDED, english(found.message), number)
            return number

        return await self._database.write(work)

    async def keep_validation(self, job_id: int, model_id: int, campaign_id: int, found: Validation) -> int:
        """Store a validation and end the job."""
        document = to_document(found)
        message = "The model passed." if found.passed else "The model did not pass."

        def work(connection: Connection) -> int:
            number = add_row(
                connection,
                validations,
                job_id=job_id,
                model_id=model_id,
                campaign_id=campaign_id,
                document=document,
            )
            add_job_state(connection, job_id, JobState.SUCCEEDED, message, number)
            return number

        return await self._database.write(work)

    async def keep_plan(self, job_id: int, name: str, setup: SessionSetup, plan: SessionPlan) -> int:
        """Store the session that was planned and end the job."""
        message = f"{len(plan.stops)} stops are planned."

        def work(connection: Connection) -> int:
            number = add_session(connection, name, setup, plan)
            add_job_state(connection, job_id, JobState.SUCCEEDED, message, number)
            return number

        return await self._database.write(work)

    async def identification(self, identification_id: int) -> IdentificationRecord:
        """Return an identification; raises NotFoundError."""
        query = _identifications().where(identifications.c.id == identification_id)
        return _identification(await self._one(query, "identification", identification_id))

    async def identifications(self, page: Page) -> list[IdentificationRecord]:
        """Return identifications, oldest first."""
        return [_identification(row) for row in await self._page(_identifications(), identifications, page)]

    async def model(self, model_id: int) -> ModelRecord:
        """Return a model; raises NotFoundError."""
        return _model(await self._one(_models().where(models.c.id == model_id), "model", model_id))

    async def models(self, page: Page) -> list[ModelRecord]:
        """Return models, oldest first."""
        return [_model(row) for row in await self._page(_models(), models, page)]

    async def validation(self, validation_id: int) -> ValidationRecord:
        """Return a validation; raises NotFoundError."""
        query = _validations().where(validations.c.id == validation_id)
        return _validation(await self._one(query, "validation", validation_id))

    async def validations(self, page: Page) -> list[ValidationRecord]:
        """Return validations, oldest first."""
        return [_validation(row) for row in await self._page(_validations(), validations, page)]

    async def _one(self, query: Select[Any], what: str, number: int) -> Row[Any]:
        row = await self._database.read(lambda c: c.execute(query).one_or_none())
        if row is None:
            raise NotFoundError(what, number)
        return row

    async def _page(self, query: Select[Any], table: Any, page: Page) -> list[Row[Any]]:
        ordered = query.where(table.c.id > page.after).order_by(table.c.id).limit(page.limit)
        return await self._database.read(lambda c: list(c.execute(ordered)))


def _identifications() -> Select[Any]:
    return (
        select(identifications, models.c.id.label("model_id"), campaigns.c.robot, simulated_campaign())
        .join(campaigns, campaigns.c.id == identifications.c.campaign_id)
        .outerjoin(models, models.c.identification_id == identifications.c.id)
    )


def _identification(row: Row[Any]) -> IdentificationRecord:
    found = from_document(Identification, row.document)
    return IdentificationRecord(
        row.id,
        row.recorded_at,
        row.job_id,
        row.campaign_id,
        row.model_id,
        row.robot,
        bool(row.simulated),
        found,
    )


def _models() -> Select[Any]:
    made_from = func.coalesce(identifications.c.campaign_id, diagnoses.c.campaign_id)
    return (
        select(models, simulated_campaign())
        .outerjoin(identifications, identifications.c.id == models.c.identification_id)
        .outerjoin(diagnoses, diagnoses.c.id == models.c.diagnosis_id)
        .join(campaigns, campaigns.c.id == made_from)
    )


def _model(row: Row[Any]) -> ModelRecord:
    model = from_document(Model, row.document)
    origin = row.identification_id, row.diagnosis_id
    return ModelRecord(row.id, row.recorded_at, *origin, row.robot, bool(row.simulated), model)


def _validations() -> Select[Any]:
    judged = campaigns.c.id == validations.c.campaign_id
    return select(validations, simulated_campaign()).join(campaigns, judged)


def _validation(row: Row[Any]) -> ValidationRecord:
    found = from_document(Validation, row.document)
    simulated = bool(row.simulated)
    return ValidationRecord(
        row.id, row.recorded_at, row.job_id, row.model_id, row.campaign_id, simulated, found
    )
