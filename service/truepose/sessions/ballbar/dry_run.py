"""Goes through a ballbar plan without a cell: whether it can be done, and how long it will take."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final

import numpy as np

from truepose.domain.ballbar import (
    BallbarPlan,
    BallbarStep,
    BallbarTest,
    PlannedPlacement,
    PlannedPose,
    StepKind,
)
from truepose.domain.cell import BallbarKit
from truepose.domain.robot import JointRange, Robot
from truepose.messages.message import Message, message
from truepose.sessions.ballbar.plan import sides, steps
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.interlocks import MAX_STATE_AGE_S, check_numbers, joint_outside
from truepose.sessions.engine.progress import StepTimes
from truepose.sessions.errors import PlanRefusedError

# One minute per pose of six legs, under one hour for 39 configurations with the set-up: thesis section 3.5.
_THESIS_S: Final = {
    StepKind.MOVE: 12.0,
    StepKind.INITIALISE: 10.0,
    StepKind.CONNECT_LEG: 6.0,
    StepKind.DETACH: 2.0,
    StepKind.MEASURE_SIDE: 10.0,
    StepKind.PLACE_BASE: 120.0,
    StepKind.FIT_BALL: 20.0,
    StepKind.CLAMP_CUP: 20.0,
    StepKind.REMOVE_BALL: 20.0,
    StepKind.PRECALIBRATE: 30.0,
}
_READINGS: Final = frozenset({StepKind.INITIALISE, StepKind.MEASURE_SIDE, StepKind.CONNECT_LEG})
_ENOUGH: Final = 3  # steps of a kind before their median says more than the thesis


@dataclass(frozen=True, slots=True)
class BallbarProgress:
    """How far a session is; readings include those of the calibrator."""

    readings: int
    planned: int
    skipped_poses: int
    elapsed_s: float  # time in which the session ran; pauses are not in it
    remaining_s: float
    pace_s_per_reading: float | None  # median; None before the first


def remaining_s(times: StepTimes, open_kinds: Iterable[StepKind]) -> float:
    """Return how long the steps that are still open will take."""
    expected = {kind: _expected_s(times, kind) for kind in StepKind}
    return sum(expected[kind] for kind in open_kinds)


def _expected_s(times: StepTimes, kind: StepKind) -> float:
    """Return how long a step of this kind takes: this operator's median, else the thesis' order."""
    # The median: a break in the middle of one step makes nobody slow.
    learnt = times.median_s([kind], _ENOUGH)
    return _THESIS_S[kind] if learnt is None else learnt


def pace_s_per_reading(times: StepTimes) -> float | None:
    """Return the median time of a reading; None before the first."""
    return times.median_s(_READINGS)


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
    # First what no cell could do: the steps cannot be listed of a plan that contradicts itself.
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
    # The points of a way are enough: limits are ranges of single joints, so that a straight motion between
    # two places within them stays within them.
    targets = [*step.via_rad, *([step.target_rad] if step.target_rad is not None else [])]
    for joints in targets:
        if len(joints) != robot.n_joints or not np.all(np.isfinite(joints)):
            raise PlanRefusedError(
                message("plan.refused.joints_of_step", step=step.id, joints=robot.n_joints)
            )
        outside = joint_outside(joints, limits)
        if outside is not None:
            is_end = joints is step.target_rad
            where = "plan.refused.stop_outside" if is_end else "plan.refused.way_to_stop_outside"
            raise PlanRefusedError(message(where, step=step.id, outside=outside))


def check_pose(pose: PlannedPose, kit: BallbarKit) -> None:
    """Raise PlanRefusedError where the legs of a pose cannot be what was meant."""
    who = message("plan.refused.configuration", config=pose.config)
    if len(pose.legs) < _FULL_POSE:
        raise PlanRefusedError(
            message("plan.refused.pose_legs", who=who, legs=len(pose.legs), wanted=_FULL_POSE)
        )
    if len(set(pose.legs)) < len(pose.legs):
        raise PlanRefusedError(message("plan.refused.leg_twice", who=who))
    for base, tool in pose.legs:
        if not (1 <= base <= kit.base_points and 1 <= tool <= TOOL_NESTS):
            raise PlanRefusedError(
                message("plan.refused.leg", who=who, base=base, tool=tool, cups=kit.base_points)
            )
    _check_aims(who, pose, kit)


def _check_stop(pose: PlannedPose, kit: BallbarKit) -> None:
    """Raise PlanRefusedError where a stop of a sphere test has another leg than one from the ball."""
    who = message("plan.refused.configuration", config=pose.config)
    if len(pose.legs) != 1 or pose.legs[0][0] != BALL_CUP or not 1 <= pose.legs[0][1] <= TOOL_NESTS:
        raise PlanRefusedError(
            message(
                "plan.refused.sphere_legs",
                who=who,
                legs=tuple(f"B{base}-T{tool}" for base, tool in pose.legs),
            )
        )
    _check_aims(who, pose, kit)


def _check_aims(who: Message, pose: PlannedPose, kit: BallbarKit) -> None:
    if pose.aimed_mm is None:
        return
    if len(pose.aimed_mm) != len(pose.legs):
        raise PlanRefusedError(
            message("plan.refused.aimed_lengths", who=who, legs=len(pose.legs), aimed=len(pose.aimed_mm))
        )
    off = np.subtract(pose.aimed_mm, kit.base_bars.nominal_mm)
    # Not the opposite comparison: a NaN is not within the range either.
    if not np.all(np.abs(off) <= kit.range_mm):
        raise PlanRefusedError(message("plan.refused.aimed_outside", who=who, range_mm=kit.range_mm))


def _check_numbers(plan: BallbarPlan, kit: BallbarKit) -> None:
    check_numbers(plan, *_POSITIVE)
    if plan.state_age_s > MAX_STATE_AGE_S:
        raise PlanRefusedError(message("plan.refused.state_age", age_s=plan.state_age_s))
    if kit.base_points not in {3, 4}:
        raise PlanRefusedError(message("plan.refused.cups", cups=kit.base_points))


def _check_numbering(plan: BallbarPlan) -> None:
    numbers = [placement.number for placement in plan.placements]
    if not numbers:
        raise PlanRefusedError(message("plan.refused.no_placement"))
    if numbers != list(range(1, len(numbers) + 1)):
        raise PlanRefusedError(message("plan.refused.placement_numbers", numbers=tuple(numbers)))
    poses = list(chain.from_iterable(placement.poses for placement in plan.placements))
    if not poses:
        raise PlanRefusedError(message("plan.refused.no_configuration"))
    configs = [pose.config for pose in poses]
    twice = next((config for config in configs if configs.count(config) > 1), None)
    if twice is not None:
        raise PlanRefusedError(message("plan.refused.configuration_twice", config=twice))


def _check_cups(placement: PlannedPlacement, kit: BallbarKit, test: BallbarTest | None) -> None:
    who = message("plan.refused.placement", placement=placement.number)
    wanted = list(range(1, kit.base_points + 1)) if test is None else [BALL_CUP]
    if sorted(setup.base_point for setup in placement.setups) != wanted:
        raise PlanRefusedError(message("plan.refused.held_balls", who=who, cups=tuple(wanted)))
    if len(placement.cups_mm) != kit.base_points:
        raise PlanRefusedError(
            message(
                "plan.refused.placement_cups", who=who, there=len(placement.cups_mm), cups=kit.base_points
            )
        )
    for a, b in sides(kit.base_points):
        length_mm = float(np.linalg.norm(np.subtract(placement.cups_mm[a - 1], placement.cups_mm[b - 1])))
        if not abs(length_mm - kit.base_bars.nominal_mm) <= kit.range_mm:
            raise PlanRefusedError(
                message(
                    "plan.refused.cups_apart",
                    who=who,
                    first=a,
                    second=b,
                    length_mm=length_mm,
                    nominal_mm=kit.base_bars.nominal_mm,
                    range_mm=kit.range_mm,
                )
            )
    for pose in placement.poses:
        if pose.placement != placement.number:
            raise PlanRefusedError(
                message("plan.refused.other_placement", config=pose.config, placement=pose.placement, who=who)
            )
