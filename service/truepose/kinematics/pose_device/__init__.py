"""The pose device: six ballbar lengths between three cups and three nests give the pose of the tool."""

from truepose.kinematics.pose_device.assemblies import Assembly, assemblies, distinct, measurable
from truepose.kinematics.pose_device.cascade import (
    base_triangle,
    fourth_cup,
    points_covariance,
    solution_gradient,
    solve,
)
from truepose.kinematics.pose_device.designs import DESIGNS, Design, designs
from truepose.kinematics.pose_device.least_squares import (
    PoseEstimate,
    fitting_poses,
    least_squares_pose,
)
from truepose.kinematics.pose_device.legs import Fixtures, LinearLegs, foreseen, linear_legs
from truepose.kinematics.pose_device.poses import Pose, pose_covariance, pose_of, turn_between
from truepose.kinematics.pose_device.recognition import RecognisedAssembly, recognise_assembly

__all__ = [
    "DESIGNS",
    "Assembly",
    "Design",
    "Fixtures",
    "LinearLegs",
    "Pose",
    "PoseEstimate",
    "RecognisedAssembly",
    "assemblies",
    "base_triangle",
    "designs",
    "distinct",
    "fitting_poses",
    "foreseen",
    "fourth_cup",
    "least_squares_pose",
    "linear_legs",
    "measurable",
    "points_covariance",
    "pose_covariance",
    "pose_of",
    "recognise_assembly",
    "solution_gradient",
    "solve",
    "turn_between",
]
