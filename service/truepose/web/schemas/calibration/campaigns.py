"""Campaigns: the folder of one measured robot, as a zip."""

from pydantic import Field

from truepose.storage.records import CampaignRecord
from truepose.web.schemas.base import (
    VISIBLE,
    Number,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    Simulated,
    example,
)


class CampaignRequest(Request):
    """What to make a campaign of, beside the calibration session."""

    model_config = example({"name": "left arm", "validation_session_id": 2})

    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    validation_session_id: Number | None = Field(
        None, description="Its readings never identify, only judge.", examples=[2]
    )


class SessionsRequest(Request):
    """Sessions to make a campaign of."""

    model_config = example({"name": "left arm", "session_ids": [3, 2]})

    name: str = Field("campaign", min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm"])
    session_ids: list[Number] = Field(
        min_length=1, max_length=2, description="The one that identifies, then the one that judges, if any."
    )


class CampaignReply(Reply):
    """A stored campaign."""

    id: RecordId
    recorded_at: RecordedAt
    name: str = Field(examples=["left arm"])
    robot: str = Field(description="As the campaign names it; it brings its own table.")
    session_ids: list[int] = Field(description="It was made of these; empty for an upload.")
    simulated: Simulated
    measured_on: str | None = Field(
        description="Day of the readings, as the upload or its description said; null: neither did.",
        examples=["2026-03-03"],
    )
    robot_serial_number: str | None = Field(
        description="As the upload or its description said; null: neither did. Of sessions, see theirs.",
        examples=["120-500123"],
    )
    instrument_serial_number: str | None = Field(
        description="Of what read all of it, as the robot's.", examples=["391234"]
    )
    calibration_points: int = Field(examples=[55])
    validation_points: int = Field(examples=[1000])
    calibration_legs: int
    validation_legs: int
    calibration_contacts: int = Field(description="Readings of closed loops.")
    validation_contacts: int
    reference_readings: int = Field(description="Looks at fixed nests.")
    ignored: list[str] = Field(description="Columns and keys kept but not understood, a sentence each.")
    notes: list[str]
    archive_url: str = Field(examples=["/api/v1/campaigns/3/archive"])


def campaign_reply(record: CampaignRecord) -> CampaignReply:
    """Return a campaign as it travels."""
    archive_url = f"/api/v1/campaigns/{record.id}/archive"
    return CampaignReply.of(record, record.summary, archive_url=archive_url, simulated=record.simulated)
