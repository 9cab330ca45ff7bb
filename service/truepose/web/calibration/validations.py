"""Validations: a model judged on readings that it was not made from."""

from fastapi import Response, status

from truepose.web.context import Here
from truepose.web.jobs import queued
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, OptionalKey, Sender
from truepose.web.resources import resource
from truepose.web.schemas.calibration.results import ValidationReply, ValidationRequest, validation_reply
from truepose.web.schemas.jobs import JobReply

router = resource("/validations", tags=["validations"])


@router.post("", status_code=status.HTTP_202_ACCEPTED, responses=problems(400, 404, 409, 413, 415, 422, 503))
async def validate_model(
    here: Here, wanted: ValidationRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Judge a model in a worker process; the job's result is the validation."""
    number = await here.job_desk.validate(wanted.model_id, wanted.campaign_id, wanted.limit_mm, key, sender)
    return await queued(here, number, response)


@router.get("", responses=listing(422, 503))
async def list_validations(here: Here, paging: Paged) -> list[ValidationReply]:
    """List validations, oldest first."""
    return paging.shown(await here.results.validations(paging.page), validation_reply)


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_validation(here: Here, id: Id) -> ValidationReply:
    """Show a validation: the document that `truepose validate --json` prints."""
    return validation_reply(await here.results.validation(id))
