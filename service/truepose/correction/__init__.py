"""Corrected joint targets: the identified model turned round, so that the real tool arrives."""

from truepose.correction.joint_targets import (
    correct,
    flange_in_base,
    in_world,
    meant_by_joints,
    shifted_by,
    tool_nests_mm,
)
from truepose.correction.results import ANY_BRANCH, Corrections, Status, Summary, joined
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
    "in_world",
    "joined",
    "likely_mistake",
    "meant_by_joints",
    "of_poses",
    "shifted_by",
    "tool_nests_mm",
]
