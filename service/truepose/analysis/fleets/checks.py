"""What is planned from a campaign of a fleet: the quick check of its robot, and what a new one needs."""

from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Campaign
from truepose.fleet.answer.check import check_of
from truepose.fleet.changes import Account
from truepose.fleet.pooled import of_a_new_robot
from truepose.fleet.promise import Promise, promise
from truepose.fleet.quick_check import QuickCheck
from truepose.identification import identify
from truepose.planning.promise.subjects import Subject, of_campaign
from truepose.words.catalogue import english


def promise_from(account: Account, robot: str, campaign: Campaign) -> Promise:
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


def check_from(account: Account, robot: str, campaign: Campaign, grown_mm: float) -> QuickCheck:
    """Choose the configurations where a robot was measured last, before the same instrument.

    Raises
    ------
    ConfigurationError
        Nothing can be identified from the campaign, or it has no positions.
    """
    subject = _subject(robot, campaign)
    return check_of(account, robot, subject.space, subject.knowns, grown_mm)


def _subject(robot: str, campaign: Campaign) -> Subject:
    answer = identify(campaign)
    if answer.model is None:
        raise ConfigurationError(
            f"Nothing can be planned from the last campaign of {robot}: {english(answer.message)}"
        )
    # What the usual effects lack, the fleet has as parameters of its own: waves and gaps.
    return of_campaign(campaign, answer.model).lacking(0.0)
