import numpy as np
import pytest

from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.instruments.robot.kinematics import UnreachableError, reach
from truepose_simulators.physics.rigid import motion
from truepose_simulators.physics.robots import ARMS

ARM = ARMS["irb120"]


def test_joint_angles_near_the_start_are_found_again_from_their_pose():
    rng = np.random.default_rng(4)
    for _ in range(20):
        joints = rng.uniform(-1.0, 1.0, 6) + np.array([0.0, 0.3, -0.5, 0.0, 1.5, 0.0])
        frame = nominal_flange(ARM, joints[np.newaxis])[0]

        found = reach(ARM, frame, joints + rng.uniform(-0.05, 0.05, 6))

        # Newton stops at 1e-7 mm and 1e-10 rad; a poorly conditioned wrist multiplies by some hundred.
        assert found == pytest.approx(joints, abs=1e-7)


def test_a_pose_out_of_reach_is_refused():
    far = motion(np.array([2000.0, 0.0, 500.0]), np.eye(3))

    with pytest.raises(UnreachableError):
        reach(ARM, far, np.zeros(6))
