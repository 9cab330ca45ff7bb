"""Errors by place and by posture: of readings whose errors are known from where they are."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement
from truepose.identification.model.validity import measured_zone
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import BRANCH_NAMES, branch_of
from truepose.validation.validate import validate

_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))


def readings(robot, joints, error_mm):
    """Readings that are off by what `error_mm` says of the places (n, 3) of the flange frame, along x."""
    nest = 1 + np.arange(len(joints)) % len(NESTS)
    chain = nominal_chain(robot, joints)
    places = chain.points(np.array(NESTS)[nest - 1])
    places[:, 0] += error_mm(chain.end_origin)
    return PointReadings(Stops(np.arange(len(joints)), joints), nest, places, np.full(len(joints), 0.01))


def judged(robot, joints, error_mm=lambda places: 0.1 + 0.0 * places[:, 0], **changes):
    placed = {"base": FramePlacement(), "nests": _CENTRES, "nominal_nests": _CENTRES}
    return validate(model_of(robot, **placed, **changes), readings(robot, joints, error_mm)).places


def test_an_error_that_grows_away_from_the_zone_is_seen_there():
    zone = measured_zone(IRB_120, configurations(60, seed=8))
    middle = judged(IRB_120, configurations(1), zone=zone).zone_centre_mm

    def error(places):
        return 1e-3 * np.linalg.norm(places - np.array(middle), axis=1)

    found = judged(IRB_120, configurations(300), error, zone=zone)

    assert found.zone_stated
    assert sum(shell.errors.identified.n for shell in found.from_zone) == 300
    assert 4 <= len(found.from_zone) <= 8
    for shell in found.from_zone:
        assert 1e-3 * shell.from_mm <= shell.errors.identified.mean_mm <= 1e-3 * shell.to_mm
        assert shell.errors.identified.max_mm <= 1e-3 * shell.to_mm


def test_the_zone_of_the_model_has_its_middle_and_holds_what_it_was_made_of():
    joints = configurations(60, seed=8)
    places = nominal_chain(IRB_120, joints).end_origin

    found = judged(IRB_120, configurations(1), zone=measured_zone(IRB_120, joints))

    assert found.zone_centre_mm == pytest.approx(0.5 * (places.min(axis=0) + places.max(axis=0)))
    away = np.linalg.norm(places - np.array(found.zone_centre_mm), axis=1)
    # 26 directions leave corners: what is farthest out is underrated by 8 % at most
    assert 0.92 * away.max() <= found.zone_radius_mm <= away.max()


def test_a_zone_stands_where_its_robot_stands():
    joints = configurations(5)
    zone = measured_zone(IRB_120, joints)
    turned = FramePlacement(100.0, 200.0, 300.0, 0.0, 0.0, np.pi / 2)
    here = judged(IRB_120, joints, zone=zone).zone_centre_mm
    placed = model_of(IRB_120, base=turned, nests=_CENTRES, nominal_nests=_CENTRES, zone=zone)

    there = validate(placed, readings(IRB_120, joints, lambda _: 0.0)).places.zone_centre_mm

    assert there == pytest.approx((100.0 - here[1], 200.0 + here[0], 300.0 + here[2]))


def test_an_error_that_grows_away_from_axis_1_is_seen_there():
    found = judged(IRB_120, configurations(300), lambda places: 1e-3 * np.hypot(places[:, 0], places[:, 1]))

    assert sum(shell.errors.identified.n for shell in found.from_axis) == 300
    for shell in found.from_axis:
        assert 1e-3 * shell.from_mm <= shell.errors.identified.mean_mm <= 1e-3 * shell.to_mm


def test_postures_are_apart():
    joints = np.vstack([configurations(50), np.pi * np.random.default_rng(0).uniform(-1.0, 1.0, (250, 6))])
    posture = branch_of(IRB_120, joints)

    found = judged(IRB_120, joints, lambda _: 0.1 * (1 + posture))

    assert [one.branch for one in found.branches] == list(BRANCH_NAMES)
    for number, one in enumerate(found.branches):
        assert one.errors.identified.n == np.count_nonzero(posture == number)
        assert one.errors.identified.mean_mm == pytest.approx(0.1 * (1 + number))


def test_an_arm_without_named_branches_has_none():
    joints = np.random.default_rng(3).uniform(-1.0, 1.0, (20, 7))

    found = judged(SEVEN_AXES, joints)

    assert found.branches == ()
    assert sum(shell.errors.identified.n for shell in found.from_axis) == 20


def test_a_model_that_says_no_zone_is_judged_about_the_middle_of_the_readings():
    joints = configurations(40)

    found = judged(IRB_120, joints)

    assert not found.zone_stated
    assert found.zone_centre_mm == pytest.approx(nominal_chain(IRB_120, joints).end_origin.mean(axis=0))


def test_one_reading_stands_in_one_shell():
    found = judged(IRB_120, configurations(1))

    assert [len(shells) for shells in (found.from_zone, found.from_axis, found.branches)] == [1, 1, 1]
    assert found.zone_radius_mm == 0.0
