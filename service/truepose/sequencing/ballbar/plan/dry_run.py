"""Goes through a ballbar plan without a cell: whether it can be done, and how long it will take."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final

import numpy as np

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import (
    BallbarPlan,
    BallbarStep,
    BallbarTest,
    PlannedPlacement,
    PlannedPose,
    StepKind,
)
from truepose.domain.robot import JointRange, Robot
from truepose.sequencing.ballbar.plan.agenda import sides, steps
from truepose.sequencing.ballbar.plan.pace import remaining_s
from truepose.sequencing.ballbar.state_so_far import READINGS
from truepose.sequencing.engine.motion.interlocks import MAX_STATE_AGE_S, joint_outside
from truepose.sequencing.engine.pace import StepTimes
from truepose.sequencing.errors import PlanRefusedError
from truepose.sequencing.plan_numbers import check_numbers

TOOL_NESTS: Final = 3
BALL_CUP: Final = 1  # of the base fixture, from which a sphere test measures
_FULL_POSE: Final = 6  # lengths that fix six degrees of freedom
_POSITIVE: Final = (
    "precalibrate_after", "stable_s", "stable_mm", "state_age_s", "tool_speed_mm_s",
    "orientation_speed_rad_s",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class BallbarDryRun:
    """What a plan amounts to, where nothing is skipped."""

    placements: int
    poses: int
    readings: int  # those of the calibrator included
    moves: int
    duration_s: float  # at the pace of the thesis


def dry_run(plan: BallbarPlan, kit: BallbarKit) -> BallbarDryRun:
    """Return what a plan amounts to."""
    kinds = [step.kind for step in steps(plan, kit)]
    return BallbarDryRun(
        placements=len(plan.placements),
        poses=sum(len(placement.poses) for placement in plan.placements),
        readings=sum(kind in READINGS for kind in kinds),
        moves=kinds.count(StepKind.MOVE),
        duration_s=remaining_s(StepTimes(), kinds),
    )


def check_plan(plan: BallbarPlan, kit: BallbarKit, robot: Robot, limits: Sequence[JointRange]) -> None:
    """Raise PlanRefusedError, with one sentence, for the first thing that cannot be done as planned."""
    check_structure(plan, kit)
    for step in steps(plan, kit):
        check_motion(step, robot, limits)


def check_structure(plan: BallbarPlan, kit: BallbarKit) -> None:
    """Raise PlanRefusedError for what no cell could do."""
    _check_numbers(plan, kit)
    _check_numbering(plan)
    for placement in plan.placements:
        _check_cups(placement, kit, plan.test)
        for pose in placement.poses:
            (check_pose if plan.test is None else _check_stop)(pose, kit)


def check_motion(step: BallbarStep, robot: Robot, limits: Sequence[JointRange]) -> None:
    """Raise PlanRefusedError where the motion of a step leaves the joint limits, on its way or at its end."""
    targets = [*step.via_rad, *([step.target_rad] if step.target_rad is not None else [])]
    for joints in targets:
        if len(joints) != robot.n_joints or not np.all(np.isfinite(joints)):
            raise PlanRefusedError(f"The step {step.id} needs {robot.n_joints} finite joint angles.")
        outside = joint_outside(joints, limits)
        if outside is not None:
            where = "The stop" if joints is step.target_rad else "The way to the stop"
            raise PlanRefusedError(f"{where} of step {step.id} lies outside the limits: {outside}.")


def check_pose(pose: PlannedPose, kit: BallbarKit) -> None:
    """Raise PlanRefusedError where the legs of a pose cannot be what was meant."""
    who = f"Configuration {pose.config}"
    if len(pose.legs) < _FULL_POSE:
        raise PlanRefusedError(f"{who} has {len(pose.legs)} legs; a full pose takes {_FULL_POSE}.")
    if len(set(pose.legs)) < len(pose.legs):
        raise PlanRefusedError(f"{who} has a leg twice; every pair is connected once.")
    for base, tool in pose.legs:
        if not (1 <= base <= kit.base_points and 1 <= tool <= TOOL_NESTS):
            raise PlanRefusedError(
                f"{who} has the leg B{base}-T{tool}; there are {kit.base_points} cups and 3 nests."
            )
    _check_aims(who, pose, kit)


def _check_stop(pose: PlannedPose, kit: BallbarKit) -> None:
    """Raise PlanRefusedError where a stop of a sphere test has another leg than one from the ball."""
    who = f"Configuration {pose.config}"
    if len(pose.legs) != 1 or pose.legs[0][0] != BALL_CUP or not 1 <= pose.legs[0][1] <= TOOL_NESTS:
        raise PlanRefusedError(f"{who} has the legs {pose.legs}; a sphere test takes one, from base point 1.")
    _check_aims(who, pose, kit)


def _check_aims(who: str, pose: PlannedPose, kit: BallbarKit) -> None:
    if pose.aimed_mm is None:
        return
    if len(pose.aimed_mm) != len(pose.legs):
        raise PlanRefusedError(f"{who} has {len(pose.legs)} legs and {len(pose.aimed_mm)} aimed lengths.")
    off = np.subtract(pose.aimed_mm, kit.base_bars.nominal_mm)
    if not np.all(np.abs(off) <= kit.range_mm):
        raise PlanRefusedError(f"{who} is aimed outside the range of the ballbar, +-{kit.range_mm:g} mm.")


def _check_numbers(plan: BallbarPlan, kit: BallbarKit) -> None:
    check_numbers(plan, *_POSITIVE)
    if plan.state_age_s > MAX_STATE_AGE_S:
        raise PlanRefusedError(f"The plan's state_age_s is {plan.state_age_s}; the limit is 2 s.")
    if kit.base_points not in {3, 4}:
        raise PlanRefusedError(f"The base fixture has {kit.base_points} cups; it takes 3 or 4.")


def _check_numbering(plan: BallbarPlan) -> None:
    numbers = [placement.number for placement in plan.placements]
    if not numbers:
        raise PlanRefusedError("The plan has no placement of the base fixture; it takes at least one.")
    if numbers != list(range(1, len(numbers) + 1)):
        raise PlanRefusedError(f"The placements are numbered {numbers}; number them 1, 2, ... in order.")
    poses = list(chain.from_iterable(placement.poses for placement in plan.placements))
    if not poses:
        raise PlanRefusedError("The plan has no configuration; choose at least one.")
    configs = [pose.config for pose in poses]
    twice = next((config for config in configs if configs.count(config) > 1), None)
    if twice is not None:
        raise PlanRefusedError(f"Configuration {twice} is in the plan twice; number a revisit anew.")


def _check_cups(placement: PlannedPlacement, kit: BallbarKit, test: BallbarTest | None) -> None:
    who = f"Placement {placement.number}"
    wanted = list(range(1, kit.base_points + 1)) if test is None else [BALL_CUP]
    if sorted(setup.base_point for setup in placement.setups) != wanted:
        raise PlanRefusedError(f"{who} must have the arm hold the ball once for each cup {wanted}.")
    if len(placement.cups_mm) != kit.base_points:
        raise PlanRefusedError(f"{who} has {len(placement.cups_mm)} cups; the fixture has {kit.base_points}.")
    for a, b in sides(kit.base_points):
        length_mm = float(np.linalg.norm(np.subtract(placement.cups_mm[a - 1], placement.cups_mm[b - 1])))
        if not abs(length_mm - kit.base_bars.nominal_mm) <= kit.range_mm:
            raise PlanRefusedError(
                f"{who} has cups {a} and {b} {length_mm:.2f} mm apart; the ballbar measures "
                f"{kit.base_bars.nominal_mm:g} +-{kit.range_mm:g} mm."
            )
    for pose in placement.poses:
        if pose.placement != placement.number:
            raise PlanRefusedError(
                f"Configuration {pose.config} is of placement {pose.placement}, not of {who}."
            )
