"""Corrected joint targets: the identified model turned round, so that the real tool arrives."""

from truepose.correction.corrections import ANY_BRANCH, Corrections, Status, joined
from truepose.correction.goals import FLANGE, Goals, of_poses
from truepose.correction.joint_targets import correct, in_world
from truepose.correction.summary import Summary

__all__ = [
    "ANY_BRANCH",
    "FLANGE",
    "Corrections",
    "Goals",
    "Status",
    "Summary",
    "correct",
    "in_world",
    "joined",
    "of_poses",
]
