"""Corrected joint targets: the identified model turned round, so that the real tool arrives."""

from truepose.correction.joint_targets import (
    correct,
    flange_in_base,
    goals_of_joints,
    in_world,
    pose_shifts,
    tool_nests_mm,
)
from truepose.correction.results import ANY_BRANCH, Corrections, Status, Summary, stack_tables
from truepose.correction.target_plausibility import OTHER_READINGS, likely_mistake
from truepose.correction.target_poses import FLANGE, Goals, of_poses

__all__ = [
    "ANY_BRANCH",
    "FLANGE",
    "OTHER_READINGS",
    "Corrections",
    "Goals",
    "Status",
    "Summary",
    "correct",
    "flange_in_base",
    "goals_of_joints",
    "in_world",
    "likely_mistake",
    "of_poses",
    "pose_shifts",
    "stack_tables",
    "tool_nests_mm",
]
