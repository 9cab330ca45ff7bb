"""Robot, type or instrument, since when, and nothing where nothing changes."""

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.fleet.changes import account_of
from truepose.fleet.trend import along, passing

_GAP = np.array([0.0, 0.0, 1.0, 0.0])
_SCALE = np.array([0.0, 0.0, 0.0, 1.0])


def _told(made):
    account = account_of(made.fleet())
    return account, [
        (one.change.scope, one.change.of, one.change.cause.effect, one.change.kind) for one in account.named
    ]


@pytest.mark.parametrize("seed", range(10, 16))
def test_where_nothing_changes_nothing_is_named(seed):
    account, named = _told(drawn(seed, readings=30))

    assert named == []
    assert account.tried > 60


def test_a_robot_that_ages_is_named_with_its_cause():
    account, named = _told(drawn(21, readings=40, drift=lambda i, k, month: 0.6 * month * (i == 4) * _GAP))

    assert named == [("robot", "robot 4", "geometry", "linear")]
    change = account.named[0]
    assert change.change.cause.subject == "link 4"
    assert change.amount[-1] == pytest.approx(1.8, abs=4 * float(np.sqrt(change.covariance[-1, -1])))


def test_a_step_is_named_with_its_day():
    account, named = _told(
        drawn(22, readings=40, months=6, drift=lambda i, k, month: 2.0 * (month >= 3) * (i == 1) * _GAP)
    )

    assert [one[3] for one in named] == ["step"]
    assert account.named[0].change.since == 90.0
    assert passing(account.fleet, account.named[0], 1.0) is None


@pytest.mark.parametrize("widths", [6.0, 12.0, 100.0])
@pytest.mark.parametrize("seed", [22, 23])
def test_a_change_of_many_widths_is_one_change_of_its_whole_size(seed, widths):
    def drift(robot, _tracker, month):
        return widths * (month >= 3) * (robot == 1) * _GAP

    account, named = _told(drawn(seed, readings=40, months=6, drift=drift))

    assert named == [("robot", "robot 1", "geometry", "step")]
    (change,) = account.named
    assert change.amount[-1] == pytest.approx(widths, abs=4.0 * float(np.sqrt(change.covariance[-1, -1])))
    course = along(account, change)
    expected = np.where(course.day >= 90.0, change.size_mm, 0.0)
    assert np.abs((course.size_mm - expected) / course.u_mm).max() < 4.0


def test_a_line_among_many_months_is_named_once_where_a_later_campaign_is_left_out():
    otherwise = np.array([1.5, -1.5, 0.0, 0.0])

    def drift(robot, _tracker, month):
        return (robot == 1) * (1.5 * max(month - 7, 0) * _GAP + (month == 16) * otherwise)

    account, named = _told(drawn(26, readings=40, months=18, drift=drift))

    assert [(one.robot, one.day) for one in account.unlike] == [("robot 1", 480.0)]
    assert named == [("robot", "robot 1", "geometry", "linear")]


def test_a_step_whose_first_campaign_is_left_out_is_named_from_the_next_one_on():
    otherwise = np.array([1.5, -1.5, 0.0, 0.0])

    def drift(robot, _tracker, month):
        return (robot == 1) * (4.0 * (month >= 3) * _GAP + (month == 3) * otherwise)

    account, named = _told(drawn(22, readings=40, months=6, drift=drift))

    assert [(one.robot, one.day) for one in account.unlike] == [("robot 1", 90.0)]
    assert named == [("robot", "robot 1", "geometry", "step")]
    assert account.named[0].change.since == 120.0
    assert account.named[0].rivals == ()


def test_a_change_that_began_later_is_named_with_its_beginning_and_its_forecast_counts_from_there():
    account, named = _told(
        drawn(26, readings=60, months=6, drift=lambda i, k, month: 0.8 * max(month - 2, 0) * (i == 3) * _GAP)
    )

    assert named == [("robot", "robot 3", "geometry", "linear")]
    change = account.named[0]
    assert change.change.since == 60.0
    assert passing(account.fleet, change, 2.0 * change.size_mm).day == pytest.approx(240.0)


def test_growth_that_may_have_begun_a_month_later_is_named_as_there_from_the_first():
    account, named = _told(
        drawn(66, readings=40, months=6, drift=lambda i, k, month: 0.09 * month * (i == 3) * _GAP)
    )

    assert named == [("robot", "robot 3", "geometry", "linear")]
    change = account.named[0]
    later = next(one for one in change.rivals if one.change.grows_as(change.change))
    assert change.change.since == 0.0
    assert later.ratio > change.trial.ratio


def test_what_all_robots_show_on_one_day_only_is_the_types_and_of_that_day():
    account, named = _told(
        drawn(27, readings=40, months=5, drift=lambda i, k, month: 1.0 * (month == 2) * _GAP)
    )

    assert named == [("type", "", "geometry", "day")]
    assert account.named[0].change.since == 60.0


def test_a_tracker_that_drifts_is_no_ageing_of_the_robots_that_it_measured():
    _, named = _told(
        drawn(
            23,
            robots=10,
            months=6,
            readings=40,
            day=0.0,
            drift=lambda i, k, month: 0.4 * month * (k == 1) * _SCALE,
        )
    )

    assert named == [("instrument", "tracker 1", "instrument_scale", "linear")]


def test_what_all_robots_do_is_the_types():
    _, named = _told(drawn(24, readings=40, drift=lambda i, k, month: 0.4 * month * _GAP))

    assert named == [("type", "", "geometry", "linear")]


def test_a_forecast_is_the_crossing_of_its_line():
    account, _ = _told(drawn(21, readings=40, drift=lambda i, k, month: 0.6 * month * (i == 4) * _GAP))
    change = account.named[0]

    found = passing(account.fleet, change, 2.0 * change.size_mm)

    assert found.day == pytest.approx(180.0)  # twice what it came to within 90 days
    assert found.earliest < found.day < found.latest
    for day, deviations in ((found.earliest, 1.6449), (found.latest, -1.6449)):  # 5 and 95 % of a normal size
        size_mm = change.size_mm + deviations * change.size_u_mm
        assert size_mm * day / 90.0 == pytest.approx(2.0 * change.size_mm, rel=1e-4)


def test_campaigns_that_scatter_more_than_their_readings_count_less():
    rng = np.random.default_rng(5)
    scattered = drawn(25, readings=40, drift=lambda i, k, month: 0.5 * rng.standard_normal(4))

    account, named = _told(scattered)

    assert account.birge_ratio > 3.0
    assert named == []
