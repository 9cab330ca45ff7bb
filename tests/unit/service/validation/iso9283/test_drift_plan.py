"""P1 in groups over the hours, and when a robot counts as warm."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.errors import ConfigurationError
from truepose.validation.iso9283.drift import has_settled
from truepose.validation.iso9283.plan import Cube, drift_session, plan_poses

_POSES = plan_poses(IRB_120, Cube((370.0, 0.0, 400.0), 200.0), np.diag([1.0, -1.0, -1.0]))
_HOURS = np.arange(0.0, 8.01, 0.25)


def walk(hours, rate_mm_per_h):
    """Barycentres that go at a rate, along a direction of no axis."""
    way = np.concatenate([[0.0], np.cumsum(rate_mm_per_h(hours[1:]) * np.diff(hours))])
    return np.outer(way, [0.6, 0.0, -0.8])


def settled(rows, places_mm, scatter_mm=0.0):
    """Whether a robot has settled by ten visits about each of some places."""
    visits = 10 if scatter_mm else 1
    away = scatter_mm * np.random.default_rng(len(rows)).standard_normal((len(rows), visits, 3))
    return has_settled(3600.0 * _HOURS[rows], list(places_mm[rows][:, None] + away))


def test_p1_is_visited_in_tens_from_p2():
    session = drift_session(_POSES, nest=3)

    stops = session.stops
    assert len(stops) == 17 * 10
    assert session.ends_when_settled
    assert {stop.nest for stop in stops} == {3}
    assert [stop.group for stop in stops] == [group for group in range(1, 18) for _ in range(10)]
    for stop in stops:
        assert stop.joints_rad == pytest.approx(_POSES.joints_rad[0])
        assert stop.begin_rad == pytest.approx(_POSES.joints_rad[1])
        assert stop.repeat_of == (None if stop.config == 1 else 1)


def test_the_arm_works_at_all_poses_before_each_group_but_the_first():
    works = [stop.work for stop in drift_session(_POSES, nest=1).stops]

    assert works[0] is None
    assert [k for k, work in enumerate(works) if work is not None] == list(range(10, 170, 10))
    due_s = [work.until_s for work in works if work is not None]
    assert due_s[0] == 600.0
    assert 8 * 3600.0 < due_s[-1] < 8.2 * 3600.0
    gaps = np.diff([0.0, *due_s])
    assert (gaps[1:-1] >= gaps[:-2]).all()  # ever rarer
    rounds = np.array(works[10].places_rad)
    assert rounds == pytest.approx(_POSES.joints_rad[::-1])


def test_shorter_tests_have_the_first_groups():
    assert len(drift_session(_POSES, nest=1, hours=0.5).stops) == 4 * 10


@pytest.mark.parametrize("hours", [0.0, 0.1, 8.5, float("nan")])
def test_hours_that_are_none_are_refused(hours):
    with pytest.raises(ConfigurationError, match="must be between 10 min and 8 h"):
        drift_session(_POSES, nest=1, hours=hours)


def test_a_warm_robot_has_settled_once_it_is_ten_times_slower():
    """A rate that falls by a factor e an hour: 0.1 of that of the first hour is reached log(10) h later."""
    places = walk(_HOURS, lambda h: np.exp(-h))
    warm = [settled(range(k), places) for k in range(1, len(_HOURS) + 1)]

    assert _HOURS[warm.index(True)] == pytest.approx(1.0 + np.log(10.0), abs=0.25)
    assert all(warm[warm.index(True) :])


@pytest.mark.parametrize("rate", [lambda h: 0.0 * h + 0.05, lambda h: 0.01 * h, lambda h: 0.0 * h])
def test_a_robot_that_never_slows_down_never_settles(rate):
    places = walk(_HOURS, rate)

    assert not any(settled(range(k), places) for k in range(1, len(_HOURS) + 1))


def test_hours_that_overlap_and_single_groups_tell_nothing():
    stopped = walk(_HOURS, lambda h: np.where(h <= 0.5, 1.0, 0.0))

    assert not settled(range(8), stopped)  # until 1.75 h
    assert settled(range(13), stopped)
    late = [0, 1, 2, 12]
    assert not settled(late, stopped)


def test_a_robot_that_hardly_drifts_has_settled_once_two_hours_show_no_more_than_scatter():
    still = np.zeros((len(_HOURS), 3))

    # Each number of groups draws a scatter of its own; three slopes, each seen by chance in one of twenty.
    held = [settled(range(k), still, scatter_mm=0.02) for k in range(9, len(_HOURS) + 1)]

    assert not settled(range(8), still, scatter_mm=0.02)  # until 1.75 h
    assert sum(held) >= 0.7 * len(held)


def test_a_steady_drift_beyond_the_scatter_never_settles():
    places = walk(_HOURS, lambda h: 0.0 * h + 0.1)

    # A barycentre is known to 6 um, and walks by 100 um an hour.
    assert not any(settled(range(k), places, scatter_mm=0.02) for k in range(1, len(_HOURS) + 1))
