"""Closing sessions: as calibrated, on certificates that held or by a named person for a reason."""

from typing import Annotated, Literal

from fastapi import status
from pydantic import Field

from truepose.domain.cell import ClosedAs, Closing, Standing
from truepose.exchange.results.document import FieldSource, null_if_empty
from truepose.web.context import Here
from truepose.web.resources import CHANGE, READ, Id, resource
from truepose.web.schemas import PersonName, Reply, Request


class ClosingRequest(Request):
    """Who closes a session, and as what."""

    closed_as: ClosedAs = Field(examples=["calibrated"])
    person: PersonName
    reason: str = Field(
        "",
        max_length=2000,
        description="Needed where a certificate did not hold; every report prints it.",
        examples=["The laboratory returns the tracker on Monday; it was checked on the scale bar."],
    )


class CertificateReply(Reply):
    """A certificate as it stood when the last reading was taken."""

    what: Annotated[str, FieldSource("paper.of")] = Field(examples=["laser tracker"])
    serial_number: Annotated[str | None, null_if_empty("paper.serial_number")] = Field(examples=["391234"])
    certificate: Annotated[str | None, null_if_empty("paper.certificate")] = Field(
        examples=["ISO 10360-10 report 2026-0815"]
    )
    expires: Annotated[str | None, null_if_empty("paper.expires")] = Field(
        description="ISO date; null: nobody said it.", examples=["2027-03-31"]
    )
    standing: Standing = Field(description="`ends soon`: 30 days or less were left.")


class ClosingReply(Reply):
    """What a session is closed as, if it is."""

    closed_as: ClosedAs | Literal["open"]
    person: str | None = Field(examples=["Ada Byron"])
    reason: str = ""
    closed_at: str | None = Field(examples=["2026-11-23T08:15:00+00:00"])
    certificates: list[CertificateReply]


router = resource("/sessions", tags=["sessions"])


@router.get("/{id}/closing", responses=READ)
async def get_closing(here: Here, id: Id) -> ClosingReply:
    """Show what a session is closed as, and the certificates that its readings rest on."""
    await here.sessions.get(id)
    closing = await here.closings.of_session(id)
    if closing is not None:
        return ClosingReply.of(closing)
    certificates = await here.closing_desk.certificates(id)
    return ClosingReply.of(closed_as="open", person=None, closed_at=None, certificates=certificates)


@router.post("/{id}/closing", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def close_session(here: Here, id: Id, wanted: ClosingRequest) -> ClosingReply:
    """Close a session that has ended, once and for all.

    As calibrated only where it finished and every certificate held when its last reading was taken, or with
    a reason that every report prints.
    """
    closing = Closing(id, wanted.closed_as, wanted.person, wanted.reason, ())
    return ClosingReply.of(await here.closing_desk.close(closing))
