"""How much a campaign holds. A worker that reads an upload needs this, and nothing of the database."""

from collections.abc import Sized
from typing import Final

from truepose.domain.measurement.campaign import Campaign
from truepose.storage.records import CampaignSummary
from truepose.words.catalogue import english

_MOST_SENTENCES: Final = 100


def summary_of(campaign: Campaign) -> CampaignSummary:
    """Return how much a campaign holds."""
    return CampaignSummary(
        calibration_points=_rows(campaign.calibration),
        validation_points=_rows(campaign.validation),
        calibration_legs=_rows(campaign.legs),
        validation_legs=_rows(campaign.validation_legs),
        calibration_contacts=_rows(campaign.contacts),
        validation_contacts=_rows(campaign.validation_contacts),
        reference_readings=_rows(campaign.reference),
        ignored=_first(tuple(map(english, campaign.ignored))),
        notes=_first(campaign.notes),
        simulated=campaign.simulated,
        measured_on=None if campaign.measured_on is None else campaign.measured_on.isoformat(),
        robot_serial_number=campaign.robot_serial_number or None,
        instrument_serial_number=campaign.instrument_serial_number or None,
    )


def _first(sentences: tuple[str, ...]) -> tuple[str, ...]:
    """Return as many sentences as a list of campaigns can show; the archive keeps all of them."""
    if len(sentences) <= _MOST_SENTENCES:
        return sentences
    more = len(sentences) - _MOST_SENTENCES
    return (*sentences[:_MOST_SENTENCES], f"There are {more} more like these in the archive.")


def _rows(table: Sized | None) -> int:
    return 0 if table is None else len(table)
