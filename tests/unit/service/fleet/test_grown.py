"""A check of a robot judged: what has grown, and nothing where nothing has."""

from dataclasses import replace
from datetime import date, timedelta

import numpy as np
import pytest

from tests.studies.fleet.simulated import Ageing, FleetTruth, draw_fleet, record_robot
from truepose.analysis.fleets.checks import grown_in
from truepose.domain.errors import ConfigurationError
from truepose.fleet.campaigns import FleetCampaign, fleet_of, information_of
from truepose.fleet.changes import account_of
from truepose.fleet.sentences import grown_said
from truepose.messages.catalogue import english

_FIRST = date(2026, 3, 2)
_TRUTH = FleetTruth(5, draw_fleet(5, 3, ageing=0, drifting=False).robots, None)


@pytest.fixture(scope="module")
def account():
    recorded = [record_robot(robot, m, "tracker A", _TRUTH, 30) for robot in _TRUTH.robots for m in (0, 1)]
    return account_of(
        fleet_of([
            FleetCampaign(
                one.robot, one.instrument, _FIRST.toordinal() + one.day, information_of(one.campaign)
            )
            for one in recorded
        ])
    )


def check(worn=None, days=150, robot="robot 01"):
    """Return the campaign of a check in the fifth month."""
    recorded = record_robot(replace(_TRUTH.robots[1], ageing=worn), 5, "tracker A", _TRUTH, 30)
    day = _FIRST + timedelta(days=days)
    return replace(recorded.campaign, robot_serial_number=robot, measured_on=day)


def test_where_nothing_has_grown_nothing_is_told(account):
    robot, found = grown_in(account, check(), 0.05)
    said = [english(one) for one in grown_said(robot, found)]

    assert robot == "robot 01"
    assert not any(one.is_told for one in found)
    assert len(found) == 17  # five springs and twelve lines of gears
    assert said[0].startswith("None of the causes checked in robot 01 has grown significantly")
    assert said[1].startswith("Growth of any of 17 causes by 0.")


def test_what_has_grown_is_told_with_its_size(account):
    robot, found = grown_in(account, check(Ageing("compliance", 3, 2e-8)), 0.05)
    first = found[0]
    place = account.fleet.names.index("c_3")
    moved_mm = np.sqrt(account.fleet.motion_mm2[place, place]) * 2e-8 / account.fleet.widths[place]

    assert (first.cause.effect, first.cause.subject, first.is_told) == ("compliance", "joint 3", True)
    assert abs(first.size_mm - moved_mm) < 4.0 * first.u_mm
    assert english(next(grown_said(robot, found))).startswith(
        "In robot 01, compliance, joint 3 has grown by 0."
    )


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"robot": "robot 7"}, "robot 'robot 7', which is not in this fleet .robot 00, robot 01, robot 02."),
        ({"robot": ""}, "the check names no robot of this fleet .robot 00,"),
        ({"days": 30}, "measured after the last campaign of robot 01"),
    ],
)
def test_what_is_no_check_of_the_fleet_is_a_sentence(account, given, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        grown_in(account, check(**given), 0.05)
