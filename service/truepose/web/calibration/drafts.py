"""Drafts: files that somebody brings, until a campaign is made of them."""

import asyncio
from typing import Annotated, Final

from fastapi import HTTPException, Query, Request, Response, status

from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.paging import Counted, listing
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.base import NUMBER_LIMIT, VISIBLE
from truepose.web.schemas.calibration.drafts import (
    DraftReply,
    DraftRequest,
    MakeRequest,
    NewDraftRequest,
    UnderstoodReply,
    draft_reply,
    understood_reply,
)

router = resource("/drafts", tags=["drafts"])
_RECEIVING_S: Final = 300.0  # 64 MB at 2 Mbit/s
_BODY: Final = {
    "requestBody": {
        "description": "The bytes of the file; without any it is an empty one, as folders have them.",
        "required": False,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
FileName = Annotated[
    str,
    Query(
        min_length=1,
        max_length=400,
        pattern=VISIBLE,
        description="Its name, with the folders that it came in.",
        examples=["left arm/points.csv"],
    ),
]
FileNumber = Annotated[int, Query(ge=1, le=NUMBER_LIMIT, description="Number of the file.", examples=[1])]


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 409, 413, 415, 422, 503))
async def start_draft(here: Here, response: Response, wanted: NewDraftRequest) -> DraftReply:
    """Begin with nothing, or with the example; files come next. It ends 14 days after its last change."""
    draft = await (here.draft_desk.create_example() if wanted.example else here.draft_desk.create())
    response.headers["Location"] = f"/api/v1/drafts/{draft.id}"
    return draft_reply(draft)


@router.get("", responses=listing(422, 503))
async def list_drafts(here: Here, paging: Counted) -> list[DraftReply]:
    """List drafts, the latest first; there are twenty at most."""
    return paging.of(await here.draft_desk.all(), draft_reply)


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_draft(here: Here, id: Id) -> DraftReply:
    """Show the files of a draft, and what was said of them."""
    return draft_reply(await here.draft_desk.get(id))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=problems(404, 422, 503))
async def remove_draft(here: Here, id: Id) -> None:
    """Throw a draft away; what was made of it stays."""
    await here.draft_desk.remove(id)


@router.post(
    "/{id}/files",
    status_code=status.HTTP_201_CREATED,
    responses=problems(404, 408, 409, 413, 415, 422, 503),
    openapi_extra=_BODY,
)
async def add_draft_file(here: Here, request: Request, id: Id, name: FileName) -> DraftReply:
    """Add a file as it is: a table of any program, a folder's file, a zip, a robot's description.

    One of the same name is replaced. Where the connection ends before the answer, nothing is kept of it.
    """
    try:
        async with asyncio.timeout(_RECEIVING_S):
            return draft_reply(await here.draft_desk.receive(id, name, request.stream()))
    except TimeoutError as error:
        raise HTTPException(
            status.HTTP_408_REQUEST_TIMEOUT,
            f"The file did not arrive within {_RECEIVING_S:.0f} s; nothing of it was kept, send it again.",
        ) from error


@router.delete("/{id}/files", responses=problems(404, 422, 503))
async def remove_draft_file(here: Here, id: Id, number: FileNumber) -> DraftReply:
    """Take a file out of a draft."""
    return draft_reply(await here.draft_desk.remove_file(id, number))


@router.patch("/{id}", responses=problems(400, 404, 413, 415, 422, 503))
async def correct_draft(here: Here, id: Id, said: DraftRequest) -> DraftReply:
    """Say what columns and files are, which robot it is, when it was measured; correct single lines."""
    return draft_reply(await here.draft_desk.say(id, said.model_dump(mode="json", exclude_unset=True)))


@router.get("/{id}/understood", responses=problems(404, 422, 503))
async def get_understood(here: Here, id: Id) -> UnderstoodReply:
    """Show what each file and column is taken for, which robot fits, what is asked, and the first fault."""
    draft = await here.draft_desk.get(id)
    return understood_reply(await here.draft_desk.understood(draft))


@router.post(
    "/{id}/campaign",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def make_campaign_of_draft(here: Here, response: Response, id: Id, wanted: MakeRequest) -> DraftReply:
    """Make a campaign of a draft, and queue its identification and diagnosis; again, answer the same.

    Refused (409) while something is asked or cannot be read.
    """
    draft = await here.draft_desk.make(id, wanted.name)
    response.headers["Location"] = f"/api/v1/campaigns/{draft.campaign_id}"
    return draft_reply(draft)
