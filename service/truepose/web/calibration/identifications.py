"""Identifications: ask for one, read the answer."""

from fastapi import Response, status

from truepose.effects.registry import chosen_effects
from truepose.web.context import Here
from truepose.web.jobs import queued
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, OptionalKey, Sender
from truepose.web.resources import resource
from truepose.web.schemas.calibration.results import (
    IdentificationReply,
    IdentificationRequest,
    identification_reply,
)
from truepose.web.schemas.jobs import JobReply

router = resource("/identifications", tags=["identifications"])


@router.post("", status_code=status.HTTP_202_ACCEPTED, responses=problems(400, 404, 409, 413, 415, 422, 503))
async def identify_campaign(
    here: Here, wanted: IdentificationRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Identify a campaign in a worker process; the job's result is the identification."""
    effects = None if wanted.effects is None else chosen_effects(wanted.effects)
    number = await here.job_desk.identify(wanted.campaign_id, effects, key, sender)
    return await queued(here, number, response)


@router.get("", response_model_exclude_unset=True, responses=listing(422, 503))
async def list_identifications(here: Here, paging: Paged) -> list[IdentificationReply]:
    """List identifications, oldest first."""
    return paging.shown(await here.results.identifications(paging.page), identification_reply)


@router.get("/{id}", response_model_exclude_unset=True, responses=problems(404, 422, 503))
async def get_identification(here: Here, id: Id) -> IdentificationReply:
    """Show an identification: the document that `truepose identify --json` prints."""
    return identification_reply(await here.results.identification(id))
