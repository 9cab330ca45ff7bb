"""Quick checks of robots of a fleet, planned and judged, and what a new robot needs."""

from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError
from truepose.fleet.campaigns import effects_of_robot, information_of
from truepose.fleet.changes import Account
from truepose.fleet.interim_check import CauseGrowth, InterimCheck, check_of, grown
from truepose.fleet.predicted_accuracy import PredictedAccuracy, of_a_new_robot, promise
from truepose.identification import identify
from truepose.messages.catalogue import english
from truepose.planning.prediction.robots_and_cells import Subject, of_campaign

_NAMED = 3  # robots in a sentence


def promise_from(account: Account, robot: str, campaign: Campaign) -> PredictedAccuracy:
    """Say what few readings of a new robot promise with what its type says, where another was measured.

    Raises
    ------
    ConfigurationError
        Nothing can be identified from the campaign, or it has no positions.
    WorkSpaceError, TooFewCandidatesError
        Hardly any configuration can be measured there.
    """
    subject = _subject(robot, campaign)
    return promise(subject.space, of_a_new_robot(account), campaign, knowns=subject.knowns)


def check_from(account: Account, robot: str, campaign: Campaign, grown_mm: float) -> InterimCheck:
    """Choose the configurations where a robot was measured last, before the same instrument.

    Raises
    ------
    ConfigurationError
        Nothing can be identified from the campaign, or it has no positions.
    """
    subject = _subject(robot, campaign)
    return check_of(account, robot, subject.space, subject.knowns, grown_mm)


def grown_in(account: Account, campaign: Campaign, asked_mm: float) -> tuple[str, tuple[CauseGrowth, ...]]:
    """Judge a check that was measured: of which robot, and what of it has grown since its last campaign.

    Raises
    ------
    ConfigurationError
        Its robot is none of the fleet, or it is a campaign that the fleet has.
    """
    robot, day = campaign.robot_serial_number, campaign.measured_on
    if robot not in account.fleet.robots:
        known = ", ".join(account.fleet.robots[:_NAMED])
        named = f"robot {robot!r}, which is not in this fleet" if robot else "no robot of this fleet"
        raise ConfigurationError(
            f"robot_serial_number: the check names {named} ({known}). Set robot_serial_number in its "
            "campaign.json."
        )
    own = account.fleet.day[account.fleet.robot == account.fleet.robots.index(robot)]
    if day is None or day.toordinal() <= own.max():
        raise ConfigurationError(
            f"measured_on: a check must be measured after the last campaign of {robot}, but the date of this "
            f"one is {day or 'not stated'}. Set measured_on in its campaign.json, and keep it out of the "
            "archive."
        )
    told = information_of(campaign, effects_of_robot(campaign))
    return robot, grown(account, robot, told, asked_mm)


def _subject(robot: str, campaign: Campaign) -> Subject:
    answer = identify(campaign)
    if answer.model is None:
        raise ConfigurationError(
            f"No check can be planned from the last campaign of {robot}: {english(answer.message)}"
        )
    # What the usual effects lack, the fleet has as parameters of its own: waves and gaps.
    return of_campaign(campaign, answer.model).lacking(0.0)
