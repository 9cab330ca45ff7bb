"""Tables of measured points as tests of the standard."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import LegReadings, PointReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement
from truepose.kinematics.chain import nominal_chain
from truepose.messages.catalogue import english
from truepose.validation.cautions import pose_test_caution
from truepose.validation.iso9283.plan import Cube, plan_poses
from truepose.validation.iso9283.pose_test import find_cycles, pose_test

_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))
_PLAN = plan_poses(IRB_120, Cube((300.0, 0.0, 250.0), 150.0), np.diag([1.0, -1.0, -1.0]), NESTS[0])
_ERROR = np.array([0.03, 0.0, 0.04])
_QUARTER_HOUR_S = 900.0


def model():
    """An identified model that is right, beside a nominal one that is off by 1 mm in x."""
    placed = {"base": FramePlacement(), "nests": _CENTRES, "nominal_nests": _CENTRES}
    return model_of(IRB_120, nominal_base=FramePlacement(x_mm=1.0), discrepancy_mm=0.02, **placed)


def points(joints, error_mm=(0.0, 0.0, 0.0), scatter_mm=0.0, **stops):
    rng = np.random.default_rng(9)
    nest = np.ones(len(joints), dtype=np.int64)
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS[0]))
    seen = places + error_mm + scatter_mm * rng.standard_normal(places.shape)
    known = {"config": np.arange(1, len(joints) + 1)} | stops
    return PointReadings(Stops(joints_rad=joints, **known), nest, seen, np.full(len(joints), 0.01))


def cycles(n=30, **more):
    """The session that the plan asks for, as measured."""
    stops = _PLAN.session(nest=1, cycles=n).stops
    repeat_of = np.array([-1 if stop.repeat_of is None else stop.repeat_of for stop in stops])
    joints = np.array([stop.joints_rad for stop in stops])
    return points(joints, repeat_of=repeat_of, **more)


def restated(table, **stops):
    """The table with other columns of its stops."""
    return replace(table, stops=replace(table.stops, **stops))


def values(performance, symbol, component):
    found = (c for c in performance.characteristics if (c.symbol, c.component) == (symbol, component))
    return {c.subject: c.value for c in found}


def test_a_planned_session_is_found_again_in_its_table():
    found = find_cycles(cycles())

    assert found.pose.tolist() == [5, 4, 3, 2, 1] * 30
    assert found.cycle.tolist() == [cycle for cycle in range(1, 31) for _ in range(5)]
    assert found.nest == 1
    assert not found.others.any()


def test_revisits_may_have_the_number_of_the_configuration_instead():
    table = cycles()
    numbered = restated(table, config=1 + np.arange(150) % 5, repeat_of=None)

    assert find_cycles(numbered).pose.tolist() == [5, 4, 3, 2, 1] * 30


def test_times_give_the_order_where_rows_do_not():
    table = cycles()
    shuffled = np.random.default_rng(1).permutation(150)

    found = find_cycles(restated(table, time_s=np.arange(150.0)).taken(shuffled))

    assert found.pose.tolist() == [5, 4, 3, 2, 1] * 30
    assert np.array_equal(shuffled[found.rows], np.arange(150))


@pytest.mark.parametrize("lost", [0, 1, 4, 77])
def test_a_lost_row_changes_no_number(lost):
    table = cycles(31)
    kept = np.delete(np.arange(155), lost)
    numbered = restated(table, config=1 + np.arange(155) % 5, repeat_of=None)

    found = find_cycles(numbered.taken(kept))

    assert found.pose.tolist() == np.delete(np.tile([5, 4, 3, 2, 1], 31), lost).tolist()
    assert found.cycle.tolist() == np.delete(np.repeat(np.arange(1, 32), 5), lost).tolist()


def test_accuracy_is_that_of_each_model_and_repeatability_that_of_the_robot():
    found = pose_test(model(), cycles(error_mm=_ERROR, scatter_mm=0.002))

    assert (found.poses, found.cycles, found.work_space) == (5, 30, None)
    assert list(values(found.identified, "AP", "p").values()) == pytest.approx([0.05] * 5, abs=0.002)
    assert list(values(found.nominal, "AP", "x").values()) == pytest.approx([-0.97] * 5, abs=0.002)
    assert values(found.nominal, "RP", "l") == pytest.approx(values(found.identified, "RP", "l"))
    assert values(found.nominal, "RD", "p") == pytest.approx(values(found.identified, "RD", "p"))
    assert list(values(found.identified, "AD", "p")) == ["P2-P4"]


def test_a_robot_that_is_its_model_has_no_error():
    found = pose_test(model(), cycles()).identified

    assert len(found.characteristics) == 5 * 5 + 8
    assert max(abs(c.value) for c in found.characteristics) < 1e-9  # places are rounded at 1e-13 of a metre
    assert found.withheld == ()


def test_other_configurations_are_the_work_space():
    table, elsewhere = cycles(error_mm=_ERROR), points(configurations(40), error_mm=(0.3, 0.0, 0.0))
    both = PointReadings(
        Stops(
            np.concatenate([table.stops.config, 200 + elsewhere.stops.config]),
            np.vstack([table.stops.joints_rad, elsewhere.stops.joints_rad]),
            repeat_of=np.concatenate([table.stops.repeat_of, np.full(40, -1)]),
        ),
        np.ones(190, dtype=np.int64),
        np.vstack([table.position_mm, elsewhere.position_mm]),
        np.full(190, 0.01),
    )

    found = pose_test(model(), both)

    assert found.work_space.identified.n == 40
    assert found.work_space.identified.max_mm == pytest.approx(0.3)
    assert found.identified.largest("AP", "p").value == pytest.approx(0.05)


def test_a_lost_reading_withholds_the_pose():
    table = cycles(error_mm=_ERROR)

    found = pose_test(model(), table.taken(np.delete(np.arange(150), 12)))  # P3 in cycle 3

    assert {w.subject for w in found.identified.withheld} == {"P3"}
    assert "cycle 3 is missing" in english(found.identified.withheld[0].reason)


@pytest.mark.parametrize(
    ("turned", "mixed"), [(slice(0), ()), (slice(3, 4), ("P2",)), (slice(0, 2), ("P4", "P5"))]
)
def test_poses_that_were_approached_from_several_sides_are_named(turned, mixed):
    table = cycles()
    direction = np.tile(1 + 0 * table.nest[:, None], 6)
    direction[turned, 2] = -1

    found = pose_test(model(), restated(table, direction=direction))

    assert found.mixed == mixed
    said = english(pose_test_caution(found))
    assert ("Not all visits came from one direction" in said) == bool(mixed)


def test_measured_orientations_give_angles():
    table = cycles()
    turned = np.tile([np.sqrt(1.0 - 4e-8), 0.0, 0.0, 2e-4], (150, 1))  # 0.4 mrad about z
    down = np.tile([0.0, 1.0, 0.0, 0.0], (150, 1))

    found = pose_test(model(), replace(table, quaternion=product(turned, down)))

    assert list(values(found.identified, "AP", "c").values()) == pytest.approx([4e-4] * 5, abs=1e-9)
    assert list(values(found.identified, "AP", "a").values()) == pytest.approx([0.0] * 5, abs=1e-9)
    assert list(values(found.identified, "RP", "c").values()) == pytest.approx([0.0] * 5, abs=1e-9)


def product(one, other):
    """Of quaternions, w first."""
    w, v, x, u = one[:, :1], one[:, 1:], other[:, :1], other[:, 1:]
    return np.hstack([w * x - np.sum(v * u, axis=1, keepdims=True), w * u + x * v + np.cross(v, u)])


def from_three_sides(n=30):
    joints = np.tile(_PLAN.joints_rad[[3, 1, 0]], (3 * n, 1))
    way = np.repeat(np.arange(3), 3 * n)
    direction = np.tile(2 * (way == 1)[:, None] - 1, 6)
    table = points(joints, config=np.tile([4, 2, 1], 3 * n), direction=direction)
    table.stops.direction[way == 2, 0] = 1
    table.position_mm[way == 1, 1] += 0.03
    table.position_mm[way == 2, 2] += 0.04
    return table


def test_three_poses_from_three_directions_give_their_variation():
    found = pose_test(model(), from_three_sides())

    assert found.mixed == ()
    assert values(found.identified, "vAP", "p") == pytest.approx(dict.fromkeys(("P1", "P2", "P4"), 0.05))
    assert found.nominal.withheld == ()


def test_the_number_of_a_direction_tells_where_joints_cannot():
    """Two ways along axes of the base may end with the same motions of all joints."""
    ones = np.ones((270, 6), dtype=np.int64)
    alike = restated(from_three_sides(), direction=ones, group=np.repeat([1, 2, 3], 90))

    found = pose_test(model(), alike)

    assert values(found.identified, "vAP", "p") == pytest.approx(dict.fromkeys(("P1", "P2", "P4"), 0.05))


def test_a_lost_visit_of_a_direction_is_named():
    numbered = restated(from_three_sides(), group=np.repeat([1, 2, 3], 90))
    lost = 90 + 3 * 6 + 1  # P2, cycle 7 of direction 2

    found = pose_test(model(), numbered.taken(np.delete(np.arange(270), lost))).identified

    assert [w.subject for w in found.withheld] == ["P2"]
    assert "from direction 2, P2 was measured in 29 cycles (cycle 7 is missing)" in english(
        found.withheld[0].reason
    )


def test_three_poses_without_directions_are_refused():
    with pytest.raises(
        ConfigurationError, match=r"vAP requires the direction of approach of each measurement"
    ):
        pose_test(model(), restated(from_three_sides(), direction=None))


def of_one_pose(hours):
    groups = int(4 * hours) + 1
    joints = np.tile(_PLAN.joints_rad[0], (10 * groups, 1))
    group = np.repeat(np.arange(groups), 10)
    table = points(
        joints,
        config=np.ones(len(joints), dtype=np.int64),
        group=group,
        time_s=_QUARTER_HOUR_S * group + np.tile(np.arange(10.0), groups),
    )
    table.position_mm[:, 2] += 0.1 + 0.01 * group
    return table


def test_one_pose_in_groups_gives_its_drift_and_a_curve_of_every_group():
    test = pose_test(model(), of_one_pose(8))

    assert values(test.identified, "dAP", "p") == pytest.approx({"P1": 0.32}, abs=1e-9)
    assert values(test.identified, "dRP", "l") == pytest.approx({"P1": 0.0}, abs=1e-9)
    found = test.drift
    assert [point.hours for point in found.curve] == pytest.approx(np.arange(33) / 4.0)
    assert [point.moved_mm for point in found.curve] == pytest.approx(0.01 * np.arange(33), abs=1e-9)
    assert [point.accuracy_mm for point in found.curve] == pytest.approx(0.1 + 0.01 * np.arange(33))
    assert {point.visits for point in found.curve} == {10}
    assert not found.settled
    assert found.walk_mm == pytest.approx(0.32)


def test_a_robot_that_is_warm_before_eight_hours_has_figures():
    table = of_one_pose(4)
    group = table.stops.group
    table.position_mm[:, 2] += 0.01 * (np.minimum(group, 6) - group)  # no further after an hour and a half

    found = pose_test(model(), table)

    assert found.drift.settled
    assert found.drift.hours == pytest.approx(4.0)
    assert values(found.identified, "dAP", "p") == pytest.approx({"P1": 0.06}, abs=1e-9)


def test_a_robot_that_still_drifts_after_four_hours_has_none():
    found = pose_test(model(), of_one_pose(4))

    assert found.identified.characteristics == ()
    assert english(found.identified.withheld[0].reason).startswith("the groups span 4 h")
    assert len(found.drift.curve) == 17


def test_a_group_with_a_lost_visit_is_named():
    table = of_one_pose(8)

    found = pose_test(model(), table.taken(np.delete(np.arange(len(table)), 44))).identified

    assert english(found.withheld[0].reason).startswith("in group 5, P1 was measured in 9 cycles")


def test_other_tests_have_no_curve():
    assert pose_test(model(), cycles()).drift is None


def test_one_pose_alone_is_refused():
    with pytest.raises(ConfigurationError, match="for AP and RP, measure five poses"):
        pose_test(model(), restated(of_one_pose(8), group=None))


@pytest.mark.parametrize("n", [2, 4])
def test_another_number_of_poses_is_refused(n):
    joints = np.tile(_PLAN.joints_rad[:n], (30, 1))

    with pytest.raises(ConfigurationError, match=f"The table has {n} repeatedly measured poses"):
        pose_test(model(), points(joints, config=np.tile(np.arange(n), 30)))


def test_a_table_without_revisits_is_no_test():
    with pytest.raises(ConfigurationError, match="The table has no repeatedly measured pose"):
        pose_test(model(), points(configurations(20)))


def test_lengths_are_no_attained_poses():
    one = np.ones(3, dtype=np.int64)
    stops = Stops(np.arange(3), np.zeros((3, 6)))
    legs = LegReadings(stops, one, one, one, np.full(3, 300.0), np.full(3, 0.001))

    with pytest.raises(ConfigurationError, match="ballbar lengths cannot be used"):
        pose_test(model(), legs)
