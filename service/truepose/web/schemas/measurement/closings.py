"""What a session is closed as, and the certificates that its readings rest on."""

from typing import Literal

from pydantic import Field

from truepose.domain.cell.certificates import ClosedAs, Closing, JudgedPaper, Standing
from truepose.web.schemas.base import PersonName, Reply, Request


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

    what: str = Field(examples=["laser tracker"])
    serial_number: str | None = Field(examples=["391234"])
    certificate: str | None = Field(examples=["ISO 10360-10 report 2026-0815"])
    expires: str | None = Field(description="ISO date; null: nobody said it.", examples=["2027-03-31"])
    standing: Standing = Field(description="`ends soon`: 30 days or less were left.")


class ClosingReply(Reply):
    """What a session is closed as, if it is."""

    closed_as: ClosedAs | Literal["open"]
    person: str | None = Field(examples=["Ada Byron"])
    reason: str = ""
    closed_at: str | None = Field(examples=["2026-11-23T08:15:00+00:00"])
    certificates: list[CertificateReply]


def open_reply(certificates: tuple[JudgedPaper, ...]) -> ClosingReply:
    """Return that nobody has closed a session, with what that would rest on."""
    papers = [_certificate_reply(one) for one in certificates]
    return ClosingReply(closed_as="open", person=None, closed_at=None, certificates=papers)


def closing_reply(closing: Closing) -> ClosingReply:
    """Return a closing as it travels."""
    papers = [_certificate_reply(one) for one in closing.certificates]
    return ClosingReply.of(closing, certificates=papers)


def _certificate_reply(one: JudgedPaper) -> CertificateReply:
    paper = one.paper
    return CertificateReply(
        what=paper.of,
        serial_number=paper.serial_number or None,
        certificate=paper.certificate or None,
        expires=paper.expires or None,
        standing=one.standing,
    )
