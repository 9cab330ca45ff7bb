"""Which change of convention would make the nominal robot fit."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.identification.problem.initial_frames import PriorPlacement
from truepose.identification.verdict.conventions import (
    Evidence,
    Interpretation,
    change_that_fits,
    changes,
    may_leave,
    typical_mm,
    with_zero,
)
from truepose.kinematics.chain import nominal_chain
from truepose.messages.catalogue import english

KNOWN = PriorPlacement(None, np.array(NESTS), np.zeros(3, dtype=bool))


def evidence(robot, joints):
    nest = 1 + np.arange(len(joints)) % 3
    chain = nominal_chain(robot, joints)
    return Evidence(joints, nest, chain.points(np.array(NESTS)[nest - 1]))


SEEN = evidence(IRB_120, configurations(40))


def test_the_right_robot_needs_no_change():
    assert change_that_fits(IRB_120, SEEN, KNOWN, search_zeros=False) is None


def test_the_right_robot_with_its_own_errors_needs_no_change():
    rng = np.random.default_rng(0)
    noisy = replace(SEEN, position_mm=SEEN.position_mm + rng.normal(scale=1.0, size=(40, 3)))

    assert change_that_fits(IRB_120, noisy, KNOWN, search_zeros=False) is None


@pytest.mark.parametrize(
    ("joints", "position", "words"),
    [
        (np.pi / 180.0, 1.0, "radians"),
        (1.0, 1e-3, "metres"),
        (1.0, 1.0 / 25.4, "inches"),
        (np.pi / 180.0, 1e-3, "metres"),  # both: the positions are the first to be noticed
        (1.0, np.array([-1.0, 1.0, 1.0]), "left-handed"),
    ],
)
def test_units_and_handedness_are_named(joints, position, words):
    wrong = Evidence(SEEN.joints_rad * joints, SEEN.nest, SEEN.position_mm * position)

    assert words in english(change_that_fits(IRB_120, wrong, KNOWN, search_zeros=False).sentence)


@pytest.mark.parametrize("joint", range(6))
def test_a_joint_that_turns_the_other_way_is_named(joint):
    turned = SEEN.joints_rad.copy()
    turned[:, joint] *= -1.0

    change = change_that_fits(IRB_120, replace(SEEN, joints_rad=turned), KNOWN, search_zeros=False)

    # with a free base, joint 1 the other way is the mirror image of all others: either is a right answer
    assert change is not None
    assert f"joint {joint + 1} turns in the opposite direction" in english(change.sentence) or joint == 0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_joints_coupled_in_the_controller_are_named(sign):
    coupled = SEEN.joints_rad.copy()
    coupled[:, 2] -= sign * coupled[:, 1]

    change = change_that_fits(IRB_120, replace(SEEN, joints_rad=coupled), KNOWN, search_zeros=False)

    assert "joint 3 is coupled to joint 2" in english(change.sentence)
    assert ("add" if sign > 0 else "subtract") in english(change.sentence)


def test_a_zero_that_is_off_is_named_with_its_angle():
    shifted = SEEN.joints_rad + np.deg2rad([0, 0, 0, 0, -12.5, 0])

    change = change_that_fits(IRB_120, replace(SEEN, joints_rad=shifted), KNOWN)

    assert "zero of joint 5 is off by 12.50 deg" in english(change.sentence)


def test_a_robot_of_seven_joints_is_searched_as_well():
    joints = np.random.default_rng(1).uniform(-1.5, 1.5, (50, 7))
    seen = evidence(with_zero(SEVEN_AXES, 3, np.pi / 2), joints)

    assert "zero of joint 4 is off by 90 deg" in english(change_that_fits(SEVEN_AXES, seen, KNOWN).sentence)


@pytest.mark.parametrize("change", list(changes(Interpretation(IRB_120, SEEN), KNOWN)), ids=str)
def test_a_change_that_is_applied_is_told_by_the_readings(change):
    applied = change.applied(Interpretation(IRB_120, SEEN))

    # with a free base, joint 1 the other way and a left-handed frame are the same to this robot
    assert typical_mm(applied, KNOWN) > 1.0 or (change.kind, change.first) == ("other_way", 0)
    assert english(change.sentence) != change.sentence.key


@pytest.mark.parametrize("change", [None, *changes(Interpretation(IRB_120, SEEN), KNOWN)], ids=str)
@pytest.mark.parametrize("rows", [39, 40])
def test_nothing_is_ruled_out_that_a_search_would_find(change, rows):
    noisy = SEEN.position_mm + np.random.default_rng(1).normal(scale=0.3, size=(40, 3))
    right = Interpretation(IRB_120, Evidence(SEEN.joints_rad[:rows], SEEN.nest[:rows], noisy[:rows]))
    meant = right if change is None else change.applied(right)

    assert may_leave(meant, KNOWN, 1.0001 * typical_mm(meant, KNOWN))
    # what does not fit by far is ruled out; a mirror image has the distances of what it mirrors
    mirrored = change is not None and change.kind == "left_handed"
    assert may_leave(meant, KNOWN, 1.0) == (mirrored or typical_mm(meant, KNOWN) < 1.0)


def test_of_nests_that_nobody_knows_nothing_is_ruled_out():
    turned = replace(SEEN, joints_rad=-SEEN.joints_rad)
    unknown = replace(KNOWN, nest_unknown=np.ones(3, dtype=bool))

    assert not may_leave(Interpretation(IRB_120, turned), KNOWN, 0.1)
    assert may_leave(Interpretation(IRB_120, turned), unknown, 0.1)
