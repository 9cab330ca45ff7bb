"""AP, RP, vAP, AD, RD and drift against numbers worked out elsewhere or by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.iso9283 import COMMANDED, five_poses, joined, visits_of
from tests.helpers.reference import reference
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import english
from truepose.validation.iso9283.drift import Group, drift
from truepose.validation.iso9283.performance import (
    direction_performance,
    distance_performance,
    one_pose,
    pose_performance,
)
from truepose.validation.iso9283.visits import CommandedPose, Visits, barycentre_covariance, norm_uncertainty

_MAVRO = reference("nist_mavro")
_ORIGIN = CommandedPose(1, (0.0, 0.0, 0.0))
_AXES = np.eye(3)


def figure(performance, symbol, component, subject="P1"):
    found = [
        c
        for c in performance.characteristics
        if (c.symbol, c.component, c.subject) == (symbol, component, subject)
    ]
    assert len(found) == 1
    return found[0]


def about(middle, *radii_and_counts):
    """Visits in opposite pairs about a barycentre, so that their radii are known without a computation."""
    away = [
        sign * radius * _AXES[k % 3]
        for radius, pairs in radii_and_counts
        for k in range(pairs)
        for sign in (1.0, -1.0)
    ]
    return np.array(middle) + np.array(away)


def test_accuracy_is_the_way_from_the_commanded_pose_to_the_barycentre():
    seen = visits_of(1, about((3.0, 4.0, 12.0), (1.0, 5), (2.0, 10)))

    found = one_pose(_ORIGIN, seen, 30)

    assert figure(found, "AP", "p").value == pytest.approx(13.0, abs=1e-12)
    assert [figure(found, "AP", axis).value for axis in "xyz"] == pytest.approx([3.0, 4.0, 12.0], abs=1e-12)


def test_repeatability_is_mean_radius_and_three_scatters():
    """By hand: 10 radii of 1 and 20 of 2 have mean 5/3, squares about it 60/9, and S = sqrt(60/9/29)."""
    seen = visits_of(1, about((3.0, 4.0, 12.0), (1.0, 5), (2.0, 10)))

    found = figure(one_pose(_ORIGIN, seen, 30), "RP", "l")

    assert found.value == pytest.approx(5.0 / 3.0 + 3.0 * math.sqrt(60.0 / 9.0 / 29.0), abs=1e-12)
    assert f"{found.value:.6f}" == "3.105057"
    assert (found.visits, found.unit, found.clause) == (30, "mm", "7.2.2")


def test_accuracy_and_repeatability_of_certified_numbers():
    values = np.array(_MAVRO["values"])
    turns = np.outer(values, [1.0, -1.0, 2.0])
    seen = visits_of(1, np.outer(values, [1.0, 0.0, 0.0]), turns_rad=turns)

    found = one_pose(_ORIGIN, seen, 30)

    for component, factor in (("a", 1.0), ("b", -1.0), ("c", 2.0)):
        accuracy, repeatability = figure(found, "AP", component), figure(found, "RP", component)
        assert accuracy.value == pytest.approx(factor * _MAVRO["mean"], rel=1e-14)
        # a standard deviation 5,000 times below the numbers that it is of: 12 digits of 16 are left
        assert repeatability.value == pytest.approx(
            3.0 * abs(factor) * _MAVRO["standard_deviation"], rel=1e-12
        )
        assert repeatability.unit == "rad"
    assert figure(found, "AP", "x").value == pytest.approx(_MAVRO["mean"], rel=1e-14)
    assert figure(found, "AP", "p").value == pytest.approx(_MAVRO["mean"], rel=1e-14)


def test_repeatability_of_certified_radii():
    """Each radius once on either side: the mean stays, the squares double, and n - 1 becomes 99 for 49."""
    values = _MAVRO["values"]
    seen = visits_of(1, about((0.0, 0.0, 0.0), *((value, 1) for value in values)))

    found = figure(one_pose(_ORIGIN, seen, 30), "RP", "l")

    scatter = _MAVRO["standard_deviation"] * math.sqrt(98.0 / 99.0)
    assert found.value == pytest.approx(_MAVRO["mean"] + 3.0 * scatter, rel=1e-14)


def test_distance_accuracy_and_repeatability_of_certified_numbers():
    values = np.array(_MAVRO["values"])
    ends = (CommandedPose(2, (0.0, 0.0, 0.0)), CommandedPose(4, (0.0, 2.0, 0.0)))
    seen = joined(visits_of(2, np.zeros((50, 3))), visits_of(4, np.outer(values, [0.0, 1.0, 0.0])))

    found = distance_performance(ends, seen)

    for component in "py":
        accuracy = figure(found, "AD", component, "P2-P4")
        assert accuracy.value == pytest.approx(_MAVRO["mean"] - 2.0, abs=1e-15)
        repeatability = figure(found, "RD", component, "P2-P4")
        assert repeatability.value == pytest.approx(3.0 * _MAVRO["standard_deviation"], rel=1e-12)
    assert [figure(found, "RD", axis, "P2-P4").value for axis in "xz"] == [0.0, 0.0]


def test_a_distance_that_is_too_short_has_a_negative_accuracy():
    ends = (CommandedPose(2, (0.0, 0.0, 0.0)), CommandedPose(4, (500.0, 0.0, 0.0)))
    far = [[499.0 + (-1) ** k, 0.0, 0.0] for k in range(30)]

    found = distance_performance(ends, joined(visits_of(2, np.zeros((30, 3))), visits_of(4, far)))

    assert figure(found, "AD", "p", "P2-P4").value == pytest.approx(-1.0, abs=1e-12)
    assert figure(found, "RD", "p", "P2-P4").value == pytest.approx(3.0 * math.sqrt(30.0 / 29.0), abs=1e-12)


def test_variation_over_directions_is_the_largest_distance_of_barycentres():
    middles = ((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0))
    turned = (0.0, 0.002, -0.001)
    approaches = [
        visits_of(1, about(middle, (0.5, 15)), turns_rad=np.full((30, 3), turn))
        for middle, turn in zip(middles, turned, strict=True)
    ]

    found = direction_performance(approaches, poses=(1,))

    assert figure(found, "vAP", "p").value == pytest.approx(5.0, abs=1e-12)
    assert figure(found, "vAP", "b").value == pytest.approx(0.003, abs=1e-15)


def group(hours, middle, radius=1.0):
    return Group(3600.0 * hours, visits_of(1, about(middle, (radius, 5))))


def test_drift_is_the_largest_change_against_the_cold_robot():
    groups = [
        group(0.0, (1.0, 0.0, 0.0)),
        group(4.0, (4.0, 0.0, 0.0), radius=3.0),
        group(8.0, (2.0, 0.0, 0.0)),
    ]

    found = drift(_ORIGIN, groups)

    assert figure(found.performance, "dAP", "p").value == pytest.approx(3.0, abs=1e-12)
    assert figure(found.performance, "dRP", "l").value == pytest.approx(2.0, abs=1e-12)
    assert (found.walk_mm, found.hours) == (pytest.approx(3.0, abs=1e-12), 8.0)


def test_a_walk_around_the_commanded_pose_is_no_drift_of_accuracy_but_is_said():
    found = drift(_ORIGIN, [group(0.0, (1.0, 0.0, 0.0)), group(8.0, (-1.0, 0.0, 0.0))])

    assert figure(found.performance, "dAP", "p").value == pytest.approx(0.0, abs=1e-12)
    assert found.walk_mm == pytest.approx(2.0, abs=1e-12)


def test_a_perfect_robot_has_figures_of_exactly_nothing():
    seen = five_poses()

    found = pose_performance(COMMANDED, seen).joined(distance_performance(COMMANDED, seen))
    found = found.joined(direction_performance([seen, seen, seen]))

    assert {c.symbol for c in found.characteristics} == {"AP", "RP", "AD", "RD", "vAP"}
    assert {c.value for c in found.characteristics} == {0.0}
    assert {c.standard_uncertainty for c in found.characteristics} == {0.0}
    assert found.withheld == ()


def test_a_missing_repeat_is_named_and_never_made_up():
    seen = five_poses(scatter_mm=0.01)
    lost = seen.position_mm.copy()
    lost[(seen.pose == 3) & np.isin(seen.cycle, [4, 17, 18, 19])] = np.nan

    found = pose_performance(COMMANDED, replace(seen, position_mm=lost))

    assert [(w.symbol, w.subject) for w in found.withheld] == [("AP", "P3"), ("RP", "P3")]
    assert english(found.withheld[0].reason) == (
        "P3 was measured in 26 cycles (cycles 4, 17 to 19 are missing); ISO 9283 requires 30, "
        "and missing cycles are not filled in"
    )
    assert {c.subject for c in found.characteristics} == {"P1", "P2", "P4", "P5"}


def test_an_absent_row_is_missing_as_well():
    seen = five_poses(scatter_mm=0.01)
    kept = np.flatnonzero((seen.pose != 2) | (seen.cycle != 30))

    found = pose_performance(COMMANDED, seen.taken(kept)).withheld[0]

    assert english(found.reason).startswith("P2 was measured in 29 cycles (cycle 30 is missing)")


def test_a_spare_cycle_makes_up_for_a_lost_one():
    seen = five_poses(scatter_mm=0.01, cycles=31)
    kept = np.flatnonzero((seen.pose != 2) | (seen.cycle != 30))

    assert pose_performance(COMMANDED, seen.taken(kept)).withheld == ()


@pytest.mark.parametrize("n", [1, 4, 0])
def test_fewer_than_five_poses_are_refused(n):
    with pytest.raises(ConfigurationError, match=rf"five poses P1 to P5 \(got {n}\)"):
        pose_performance(COMMANDED[:n], five_poses())


def test_a_pose_that_is_commanded_twice_is_one():
    with pytest.raises(ConfigurationError, match=r"five poses P1 to P5 \(got 4\)"):
        pose_performance((*COMMANDED[:4], COMMANDED[3]), five_poses())


def test_cycles_that_hold_one_end_only_give_no_distance():
    seen = five_poses(scatter_mm=0.01, cycles=31)
    kept = np.flatnonzero(~((seen.pose == 2) & (seen.cycle == 1)) & ~((seen.pose == 4) & (seen.cycle == 2)))

    found = distance_performance(COMMANDED, seen.taken(kept))

    reasons = [english(w.reason) for w in found.withheld]
    assert reasons == ["only 29 cycles include both ends; ISO 9283 requires 30"] * 2


def test_a_distance_without_an_end_is_refused():
    with pytest.raises(ConfigurationError, match="P4 is missing from the commanded poses"):
        distance_performance(COMMANDED[:3], five_poses())


def test_two_directions_are_refused():
    with pytest.raises(
        ConfigurationError, match=r"vAP requires measurements from three directions of approach \(got 2\)"
    ):
        direction_performance([five_poses()] * 2)


def test_a_direction_with_too_few_visits_is_named():
    seen, short = five_poses(), five_poses(cycles=29)

    found = direction_performance([seen, short, seen])

    assert [w.subject for w in found.withheld] == ["P1", "P2", "P4"]
    assert english(found.withheld[0].reason).startswith("from direction 2, P1 was measured in 29 cycles")


@pytest.mark.parametrize(
    ("groups", "reason"),
    [
        ([group(0.0, (1.0, 0.0, 0.0)), group(7.9, (2.0, 0.0, 0.0))], "the groups span 7.9 h"),
        (
            [group(0.0, (1.0, 0.0, 0.0)), Group(28800.0, visits_of(1, np.zeros((9, 3))))],
            "in group 2, P1 was measured in 9 cycles",
        ),
    ],
)
def test_a_short_drift_is_withheld(groups, reason):
    found = drift(_ORIGIN, groups)

    assert [w.symbol for w in found.performance.withheld] == ["dAP", "dRP"]
    assert english(found.performance.withheld[0].reason).startswith(reason)
    assert found.walk_mm is None


@pytest.mark.parametrize("hours", [(0.0,), (0.0, 0.0), (8.0, 0.0)])
def test_drift_without_order_is_refused(hours):
    with pytest.raises(
        ConfigurationError, match="at least two groups of repeat measurements, in chronological order"
    ):
        drift(_ORIGIN, [group(h, (0.0, 0.0, 0.0)) for h in hours])


def test_a_pose_is_visited_once_a_cycle():
    pose, cycle = np.array([1, 1, 2, 3, 2]), np.array([1, 2, 2, 1, 2])

    assert len(Visits(pose[:4], cycle[:4], np.zeros((4, 3)), np.zeros(4))) == 4
    with pytest.raises(ConfigurationError, match="P2 occurs twice in cycle 2"):
        Visits(pose, cycle, np.zeros((5, 3)), np.zeros(5))


def test_the_worst_pose_stands_for_all():
    seen = five_poses()
    moved = seen.position_mm.copy()
    moved[seen.pose == 4] += [0.0, 0.0, -0.5]

    found = pose_performance(COMMANDED, replace(seen, position_mm=moved))

    assert (found.largest("AP", "p").subject, found.largest("AP", "p").value) == ("P4", pytest.approx(0.5))
    assert found.largest("AP", "z").value == pytest.approx(-0.5)
    assert found.largest("vAP", "p") is None


def test_a_shift_across_the_only_way_in_which_readings_scatter_is_known_exactly():
    rng = np.random.default_rng(1)
    for _ in range(50):
        way, other = rng.standard_normal((2, 3))
        scattered = barycentre_covariance(np.outer(rng.standard_normal(30), way))

        assert norm_uncertainty(np.cross(way, other), scattered) == pytest.approx(0.0, abs=1e-6)
