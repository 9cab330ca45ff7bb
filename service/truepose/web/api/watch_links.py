"""Watch links: whoever has one looks at one session on a screen of their own, and at nothing else."""

import contextlib
from collections.abc import AsyncGenerator
from http import HTTPStatus
from typing import Final

import segno
from fastapi import APIRouter, status
from fastapi import Request as HttpRequest
from fastapi.responses import HTMLResponse, Response, StreamingResponse
from pydantic import Field

from truepose.messages.message import message
from truepose.people.errors import UnknownPersonError
from truepose.storage.people import CredentialKind, CredentialRecord
from truepose.web.api.events import EventStream
from truepose.web.api.sessions.following import Follower, follow_session
from truepose.web.context import Context, Here
from truepose.web.middleware.rights import CurrentCaller
from truepose.web.pages.records import session_states
from truepose.web.pages.rendering import Visited
from truepose.web.problems import problem_response
from truepose.web.resources import ACT, CHANGE, READ, Id, resource
from truepose.web.schemas import RecordedAt, RecordId, Reply, Request, example


class WatchLinkRequest(Request):
    """Validity of a watch link."""

    model_config = example({"hours": 12})

    hours: int = Field(12, ge=1, le=24 * 31, description="Hours until the link expires.")


class WatchLinkReply(Reply):
    """A link that gives read-only access to one session."""

    id: RecordId
    session_id: RecordId
    expires_at: RecordedAt
    by: str = Field(description="Person who created the link.", examples=["Ada Byron"])

    @classmethod
    def about(cls, record: CredentialRecord) -> "WatchLinkReply":
        """Return a link without its secret."""
        said = record.document
        return cls.of(
            record, session_id=said["session_id"], expires_at=record.expires_at or "", by=said["by"]
        )


class WatchLinksReply(Reply):
    """All watch links of a session."""

    links: list[WatchLinkReply]


class NewWatchLinkReply(Reply):
    """A new watch link with its QR code."""

    link: WatchLinkReply
    url: str = Field(
        description="Address of the link; it is not shown again.",
        examples=["http://localhost:8000/watch/5Yl1pMGRTsAjn3ySZyfRcN0t1RZ3Rlbn8Zt4Yk4mG5k"],
    )
    qr_svg: str = Field(
        description="QR code of the link, as a data URL of an SVG image.",
        examples=["data:image/svg+xml;charset=utf-8,%3Csvg ... %3C/svg%3E"],
    )


router = resource(tags=["people"])
pages = APIRouter(include_in_schema=False)
_MODULE_PX: Final = 8
_OVER: Final = message("refused.watch_over")
_HOURS_A_DAY: Final = 24


@router.post("/sessions/{id}/watch-links", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def make_watch_link(
    here: Here, request: HttpRequest, asker: CurrentCaller, id: Id, wanted: WatchLinkRequest
) -> NewWatchLinkReply:
    """Create a watch link to a session, with its QR code; it gives read-only access."""
    await here.sessions.get(id)
    record, secret = await here.people.accounts.make_watch_link(id, wanted.hours / _HOURS_A_DAY, asker)
    url = f"{request.base_url}watch/{secret}"
    code = segno.make(url, micro=False, error="m").svg_data_uri(scale=_MODULE_PX, light="#fff")
    return NewWatchLinkReply(link=WatchLinkReply.about(record), url=url, qr_svg=code)


@router.get("/sessions/{id}/watch-links", responses=READ)
async def list_watch_links(here: Here, id: Id) -> WatchLinksReply:
    """List the watch links of a session."""
    await here.sessions.get(id)
    return WatchLinksReply(links=[WatchLinkReply.about(r) for r in _links(here, id)])


@router.delete("/watch-links/{id}", status_code=status.HTTP_204_NO_CONTENT, responses=ACT)
async def revoke_watch_link(here: Here, asker: CurrentCaller, id: Id) -> None:
    """Revoke a watch link; it stops showing the session at once."""
    if id not in {record.id for record in _links(here)}:
        raise UnknownPersonError(message("refused.no_watch_link", number=id))
    await here.people.accounts.register.revoke(id, by=asker.name)


@pages.get("/watch/{secret}", response_class=HTMLResponse)
async def watch_page(visit: Visited, secret: str) -> HTMLResponse:
    """Show a session large, for a screen beside the robot."""
    record = visit.here.people.accounts.watched_by(secret)
    if record is None:
        return visit.page("people/link_over.html", HTTPStatus.UNAUTHORIZED)
    session = await visit.here.sessions.get(record.document["session_id"])
    return visit.page("people/watch.html", session=session, states=session_states(visit.words))


@pages.get("/watch/{secret}/live", response_class=StreamingResponse)
async def follow_watched(here: Here, request: HttpRequest, secret: str) -> Response:
    """Follow the session of a link, as long as the link lasts."""
    record = here.people.accounts.watched_by(secret)
    if record is None:
        return problem_response(request, HTTPStatus.UNAUTHORIZED, _OVER)
    return EventStream(_while_it_lasts(here, secret, await _followed(here, record)))


async def _followed(here: Context, record: CredentialRecord) -> AsyncGenerator[str]:
    session = await here.sessions.get(record.document["session_id"])
    return (await follow_session(Follower(here, session.id, f"watch link {record.id}"))).events


async def _while_it_lasts(here: Context, secret: str, events: AsyncGenerator[str]) -> AsyncGenerator[str]:
    async with contextlib.aclosing(events):
        async for event in events:
            # Looked at for each one: a link that ends, or is taken back, ends a stream that has been open for
            # hours.
            if here.people.accounts.watched_by(secret) is None:
                return
            yield event


def _links(here: Context, session_id: int | None = None) -> list[CredentialRecord]:
    return [
        record
        for record in here.people.accounts.register.credentials
        if record.kind is CredentialKind.WATCH and session_id in (None, record.document["session_id"])
    ]
