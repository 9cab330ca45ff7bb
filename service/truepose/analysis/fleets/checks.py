"""The quick check of a robot of a fleet, from its last campaign."""

from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Campaign
from truepose.fleet.answer.check import check_of
from truepose.fleet.changes import Account
from truepose.fleet.quick_check import QuickCheck
from truepose.identification import identify
from truepose.planning.promise.subjects import of_campaign
from truepose.words.catalogue import english


def check_from(account: Account, robot: str, campaign: Campaign, grown_mm: float) -> QuickCheck:
    """Choose the configurations where a robot was measured last, before the same instrument.

    Raises
    ------
    ConfigurationError
        Nothing can be identified from the campaign, or it has no positions.
    """
    answer = identify(campaign)
    if answer.model is None:
        raise ConfigurationError(f"No check can be planned for {robot}: {english(answer.message)}")
    # What the usual effects lack, the fleet has as parameters of its own: waves and gaps.
    subject = of_campaign(campaign, answer.model).lacking(0.0)
    return check_of(account, robot, subject.space, subject.knowns, grown_mm)
