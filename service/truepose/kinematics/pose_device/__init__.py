"""The pose device: six ballbar lengths between three cups and three nests give the pose of the tool.

`cascade` solves the thesis' pattern of legs in closed form, `assemblies` lists the ways to put it together,
`starts` solves any six legs that hold the tool, `leg_lengths` gives the lengths at a pose and their
derivatives, and `least_squares` fits a pose to any number of legs.
"""

from truepose.kinematics.pose_device.assemblies import (
    Assembly,
    assemblies,
    check_triangle,
    distinct,
    measurable,
)
from truepose.kinematics.pose_device.cascade import (
    DESIGNS,
    Design,
    base_triangle,
    designs,
    fourth_cup,
    points_covariance,
    solution_gradient,
    solve,
)
from truepose.kinematics.pose_device.least_squares import (
    PoseEstimate,
    RecognisedAssembly,
    fitting_poses,
    least_squares_pose,
    recognise_assembly,
)
from truepose.kinematics.pose_device.leg_lengths import Fixtures, LinearLegs, foreseen, linear_legs
from truepose.kinematics.poses import Pose, pose_covariance, pose_of, turn_between

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
    "check_triangle",
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
