"""Which instruments answered in a session, and who accepted them."""

from pydantic import Field

from truepose.domain.measurement.identities import Finding, IdentityOf, IdentityTaken
from truepose.web.schemas.base import Reply


class IdentityReply(Reply):
    """What a device answered when it was asked who it is, where that said anything new."""

    device: IdentityOf
    finding: Finding = Field(description="`foreign` waits for a person; `accepted` says who it was.")
    serial_number: str | None = Field(
        description="As it answered; null: it does not say.", examples=["391234"]
    )
    expected_serial_number: str | None = Field(
        description="Of the cell file, or of the session so far; null: none.", examples=["390003"]
    )
    person: str | None = Field(description="Who accepted it.", examples=["Ada Byron"])


def identity_reply(taken: IdentityTaken) -> IdentityReply:
    """Return a line of a session's record as it travels."""
    return IdentityReply.of(
        taken, serial_number=taken.serial or None, expected_serial_number=taken.expected or None
    )
