"""Limits of robots that ship, for models that were made without them."""

from dataclasses import replace

import pytest

from tests.helpers.identification.models import model_of
from truepose.exchange.robots.named import load_robot, with_known_limits

KNOWN = load_robot("abb-irb-120")


def limits_of(**changes):
    return with_known_limits(model_of(replace(KNOWN, joint_limits=None, **changes))).robot.joint_limits


@pytest.mark.parametrize("name", ["ABB IRB 120", "abb irb-120", "ABB IRB 120, cell 4"])
def test_a_robot_of_a_known_name_and_table_has_its_makers_limits(name):
    assert limits_of(name=name) == KNOWN.joint_limits


def test_another_name_or_another_table_has_none():
    longer = replace(KNOWN.joints[2], a_mm=350.0)

    assert limits_of(name="shop robot 7") is None
    assert limits_of(joints=(*KNOWN.joints[:2], longer, *KNOWN.joints[3:])) is None


def test_limits_that_a_model_says_stay():
    own = replace(KNOWN, joint_limits=KNOWN.joint_limits[::-1])

    assert with_known_limits(model_of(own)).robot.joint_limits == own.joint_limits
