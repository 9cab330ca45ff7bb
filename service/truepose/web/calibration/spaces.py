"""Errors in space: what the pictures of results show, to be turned."""

import asyncio

from truepose.analysis.workers.tasks import judging_or_own, stored_campaign
from truepose.domain.results.identification import Model
from truepose.storage.errors import NotFoundError
from truepose.web.context import Context, Here
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.calibration.spaces import SpaceReply, space_reply

router = resource(tags=["spaces"])
_READ = problems(404, 409, 422, 503)


@router.get("/identifications/{id}/space", responses=_READ)
async def get_identification_space(here: Here, id: Id) -> SpaceReply:
    """Show errors where the tool stood: at readings kept for validation, else at those identified from."""
    record = await here.results.identification(id)
    return await _space(here, record.model_id, record.campaign_id)


@router.get("/validations/{id}/space", responses=_READ)
async def get_validation_space(here: Here, id: Id) -> SpaceReply:
    """Show errors where the tool stood, at the readings that judged the model."""
    record = await here.results.validation(id)
    return await _space(here, record.model_id, record.campaign_id)


@router.get("/diagnoses/{id}/space", responses=_READ)
async def get_diagnosis_space(here: Here, id: Id) -> SpaceReply:
    """Show errors where the tool stood: of the nominal robot, and of the model a diagnosis ends with."""
    record = await here.diagnoses.get(id)
    return await _space(here, record.model_id, record.campaign_id)


async def _space(here: Context, model_id: int | None, campaign_id: int) -> SpaceReply:
    if model_id is None:
        raise NotFoundError("model of that result", campaign_id)
    model = (await here.results.model(model_id)).model
    content = await here.campaigns.content(campaign_id)
    return await asyncio.to_thread(_drawn, model, content)


def _drawn(model: Model, content: bytes) -> SpaceReply:
    from truepose.reports.spaces.errors import error_space

    return space_reply(error_space(model, judging_or_own(stored_campaign(content))))
