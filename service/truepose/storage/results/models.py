"""What jobs made: identifications, models and validations, each stored with the end of its job."""

import dataclasses
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, func, select

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.contacts import ContactPlan
from truepose.domain.identification import Identification, Model
from truepose.domain.session import SessionPlan
from truepose.domain.validation import Validation
from truepose.messages.message import Message, Text
from truepose.messages.message import message as said
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.ledger.sessions import add_note, add_session
from truepose.storage.queries import NumberedRecords, Part, Repository
from truepose.storage.record_insertion import add_row
from truepose.storage.records import (
    IdentificationRecord,
    JobState,
    ModelRecord,
    Page,
    SessionSetup,
    ValidationRecord,
)
from truepose.storage.results.campaigns import simulated_campaign
from truepose.storage.results.jobs import add_job_state, add_result
from truepose.storage.rows import from_row
from truepose.storage.tables import campaigns, diagnoses, identifications, models, validations

_JUDGED: Final = {
    "conforms": said("job.passed"),
    "does not conform": said("job.not_passed"),
    "cannot be decided": said("job.undecided"),
}


class ResultRepository(Repository):
    """All queries about results; a result and the end of its job are one transaction."""

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._identifications = NumberedRecords(
            database, "identification", identifications, _identifications, _identification
        )
        self._models = NumberedRecords(database, "model", models, _models, _model)
        self._validations = NumberedRecords(database, "validation", validations, _validations, _validation)

    async def keep_identification(self, job_id: int, campaign_id: int, found: Identification) -> int:
        """Store an identification, with its model as a record of its own, and end the job."""
        # The model is a record of its own, to which corrections and validations refer.
        document = to_document(dataclasses.replace(found, model=None))
        model = None if found.model is None else (found.model.robot.name, to_document(found.model))

        def work(connection: Connection) -> int:
            number = add_row(
                connection, identifications, job_id=job_id, campaign_id=campaign_id, document=document
            )
            if model is not None:
                add_row(connection, models, identification_id=number, robot=model[0], document=model[1])
            add_job_state(connection, job_id, JobState.SUCCEEDED, found.message, number)
            return number

        return await self._database.write(work)

    async def keep_validation(self, job_id: int, model_id: int, campaign_id: int, found: Validation) -> int:
        """Store a validation and end the job."""
        message = said("job.no_limit") if found.decision is None else _JUDGED[found.decision.verdict]
        values = {"model_id": model_id, "campaign_id": campaign_id, "document": to_document(found)}
        return await self._database.write(lambda c: add_result(c, validations, job_id, message, **values))

    async def keep_plan(
        self,
        job_id: int,
        name: str,
        setup: SessionSetup,
        plan: SessionPlan | BallbarPlan | ContactPlan,
        notice: Text = "",
    ) -> int:
        """Store the session that was planned, with what to watch in it, and end the job."""
        message = _planned(plan)

        def work(connection: Connection) -> int:
            number = add_session(connection, name, setup, plan)
            # In the transaction of the session: a plan is never without what to watch in it.
            if notice:
                add_note(connection, number, notice)
            add_job_state(connection, job_id, JobState.SUCCEEDED, message, number)
            return number

        return await self._database.write(work)

    async def identification(self, identification_id: int) -> IdentificationRecord:
        """Return an identification; raises NotFoundError."""
        return await self._identifications.get(identification_id)

    async def identifications(self, page: Page) -> Part[IdentificationRecord]:
        """Return identifications, oldest first."""
        return await self._identifications.page(page)

    async def newest_identifications(self, count: int, month: str = "") -> list[IdentificationRecord]:
        """Return the latest identifications of a month (`2026-11`), or of all, newest first."""
        return await self._identifications.newest_of(count, month)

    async def newest_identification_of(self, campaign_id: int) -> IdentificationRecord | None:
        """Return the latest identification of a campaign; None where it has none."""
        found = await self._identifications.newest(1, identifications.c.campaign_id == campaign_id)
        return found[0] if found else None

    async def newest_validations(self, count: int, month: str = "") -> list[ValidationRecord]:
        """Return the latest validations of a month, or of all, newest first."""
        return await self._validations.newest_of(count, month)

    async def model(self, model_id: int) -> ModelRecord:
        """Return a model; raises NotFoundError."""
        return await self._models.get(model_id)

    async def models(self, page: Page) -> Part[ModelRecord]:
        """Return models, oldest first."""
        return await self._models.page(page)

    async def newest_models(self, count: int, robot: str | None = None) -> list[ModelRecord]:
        """Return the latest models, newest first; of the robots of one name, or of all."""
        return await self._models.newest(count, *([] if robot is None else [models.c.robot == robot]))

    async def validation(self, validation_id: int) -> ValidationRecord:
        """Return a validation; raises NotFoundError."""
        return await self._validations.get(validation_id)

    async def validations(self, page: Page) -> Part[ValidationRecord]:
        """Return validations, oldest first."""
        return await self._validations.page(page)


def _planned(plan: SessionPlan | BallbarPlan | ContactPlan) -> Message:
    if isinstance(plan, BallbarPlan):
        return said("job.poses_planned", poses=sum(len(place.poses) for place in plan.placements))
    return said("job.stops_planned", stops=len(plan.stops))


def _identifications() -> Select[Any]:
    return (
        select(identifications, models.c.id.label("model_id"), campaigns.c.robot, simulated_campaign())
        .join(campaigns, campaigns.c.id == identifications.c.campaign_id)
        .outerjoin(models, models.c.identification_id == identifications.c.id)
    )


def _identification(row: Row[Any]) -> IdentificationRecord:
    return from_row(IdentificationRecord, row, identification=from_document(Identification, row.document))


def _models() -> Select[Any]:
    made_from = func.coalesce(identifications.c.campaign_id, diagnoses.c.campaign_id)
    return (
        select(models, simulated_campaign())
        .outerjoin(identifications, identifications.c.id == models.c.identification_id)
        .outerjoin(diagnoses, diagnoses.c.id == models.c.diagnosis_id)
        .outerjoin(campaigns, campaigns.c.id == made_from)
    )


def _model(row: Row[Any]) -> ModelRecord:
    return from_row(ModelRecord, row, model=from_document(Model, row.document))


def _validations() -> Select[Any]:
    judged = campaigns.c.id == validations.c.campaign_id
    return select(validations, simulated_campaign()).join(campaigns, judged)


def _validation(row: Row[Any]) -> ValidationRecord:
    return from_row(ValidationRecord, row, validation=from_document(Validation, row.document))
