import numpy as np
import pytest

from simulators.errors import ScenarioError
from simulators.physics.effects import Conditions, Loads, PlantedChange, plant_effect
from simulators.physics.robots import ARMS

ARM = ARMS["irb120"]


def test_a_joint_gain_adds_its_share_of_the_commanded_angle_from_its_time_on():
    effect = plant_effect(PlantedChange("joint_gain", "joint 3", 1e-3, from_s=10.0), ARM)
    joints = np.full((2, 6), 0.5)
    conditions = Conditions(joints, np.ones((2, 6)), np.array([9.9, 10.0]), np.full(2, 23.0), np.ones(2))

    added = effect.deflect(conditions, Loads(np.zeros((2, 6)))).angles_rad

    expected = np.zeros((2, 6))
    expected[1, 2] = 0.5e-3
    assert added == pytest.approx(expected, abs=1e-18)


@pytest.mark.parametrize("subject", ["joint 0", "joint 7", "joint", "link 3", "joint 3 "])
def test_a_subject_that_the_arm_does_not_have_is_refused(subject):
    with pytest.raises(ScenarioError, match=r'must be "joint 1" to "joint 6"'):
        plant_effect(PlantedChange("joint_gain", subject, 1e-3), ARM)


def test_an_unknown_effect_is_refused_with_the_known_names():
    with pytest.raises(ScenarioError, match=r'unknown effect "joint_pain"; known: joint_gain'):
        plant_effect(PlantedChange("joint_pain", "joint 3", 1e-3), ARM)
