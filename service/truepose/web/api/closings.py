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
    """Person who closes a session, and the status to give it."""

    closed_as: ClosedAs = Field(examples=["calibrated"])
    person: PersonName
    reason: str = Field(
        "",
        max_length=2000,
        description="Reason; required if a certificate was not valid. It is printed in every report.",
        examples=["The laboratory returns the tracker on Monday; it was checked on the scale bar."],
    )


class CertificateReply(Reply):
    """State of a certificate at the time of the last reading."""

    what: Annotated[str, FieldSource("paper.of")] = Field(examples=["laser tracker"])
    serial_number: Annotated[str | None, null_if_empty("paper.serial_number")] = Field(examples=["391234"])
    certificate: Annotated[str | None, null_if_empty("paper.certificate")] = Field(
        examples=["ISO 10360-10 report 2026-0815"]
    )
    expires: Annotated[str | None, null_if_empty("paper.expires")] = Field(
        description="Expiry date (ISO); null if not stated.", examples=["2027-03-31"]
    )
    standing: Standing = Field(description="`ends soon`: 30 days or less remained.")


class ClosingReply(Reply):
    """Status with which a session was closed, if it was."""

    closed_as: ClosedAs | Literal["open"]
    person: str | None = Field(examples=["Ada Byron"])
    reason: str = ""
    closed_at: str | None = Field(examples=["2026-11-23T08:15:00+00:00"])
    certificates: list[CertificateReply]


router = resource("/sessions", tags=["sessions"])


@router.get("/{id}/closing", responses=READ)
async def get_closing(here: Here, id: Id) -> ClosingReply:
    """Return the status with which a session was closed, and the certificates of its readings."""
    await here.sessions.get(id)
    closing = await here.closings.of_session(id)
    if closing is not None:
        return ClosingReply.of(closing)
    certificates = await here.closing_desk.certificates(id)
    return ClosingReply.of(closed_as="open", person=None, closed_at=None, certificates=certificates)


@router.post("/{id}/closing", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def close_session(here: Here, id: Id, wanted: ClosingRequest) -> ClosingReply:
    """Close a session that has ended; this cannot be undone.

    It can be closed as calibrated only if it finished and every certificate was valid at the last reading, or
    with a reason that is printed in every report.
    """
    closing = Closing(id, wanted.closed_as, wanted.person, wanted.reason, ())
    return ClosingReply.of(await here.closing_desk.close(closing))
