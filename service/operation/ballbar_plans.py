"""Plans of ballbar sessions: what is wanted of one, and whether this cell and this kit can do it."""

from collections.abc import Sequence
from dataclasses import dataclass

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan, PlannedPlacement, PlannedPose
from service.domain.cell import Cell
from service.domain.robot import FramePlacement, JointRange
from service.sequencing.errors import PlanRefusedError


@dataclass(frozen=True, slots=True)
class BallbarWish:
    """What is wanted of a ballbar session."""

    given: BallbarPlan | None = None  # None: poses, or placements too, are chosen
    frames: tuple[FramePlacement, ...] = ()  # of the base fixture; none: suggested
    placements: int = 1  # how many are suggested
    poses: int = 24  # in each placement
    seed: int = 0


def check_ballbar_plan(plan: BallbarPlan, cell: Cell, kit: BallbarKit) -> None:
    """Raise PlanRefusedError, with the first reason, for a plan that this cell cannot do."""
    limits = cell.limits.joints or cell.robot.joint_limits
    configs: set[int] = set()
    for placement in plan.placements:
        _check_cups(placement, kit)
        for setup in placement.setups:
            what = f"the set-up of cup {setup.base_point} of placement {placement.number}"
            _check_joints(what, (*setup.via_rad, setup.joints_rad), cell.robot.n_joints, limits)
        for pose in placement.poses:
            if pose.config in configs:
                raise PlanRefusedError(f"Pose {pose.config} is planned twice; numbers must differ.")
            configs.add(pose.config)
            _check_legs(pose, kit)
            what = f"pose {pose.config}"
            _check_joints(what, (*pose.via_rad, pose.joints_rad), cell.robot.n_joints, limits)


def _check_cups(placement: PlannedPlacement, kit: BallbarKit) -> None:
    points = sorted(setup.base_point for setup in placement.setups)
    wanted = list(range(1, kit.base_points + 1))
    if points != wanted or len(placement.cups_mm) != kit.base_points:
        raise PlanRefusedError(
            f"Placement {placement.number} must have one set-up and one place for each of the "
            f"{kit.base_points} cups of the base fixture."
        )


def _check_legs(pose: PlannedPose, kit: BallbarKit) -> None:
    for base, tool in pose.legs:
        if base > kit.base_points or tool > 3:
            raise PlanRefusedError(
                f"Pose {pose.config} asks for the leg B{base}-T{tool}; the fixtures end at "
                f"B{kit.base_points} and T3."
            )
    if len(set(pose.legs)) < len(pose.legs):
        raise PlanRefusedError(f"Pose {pose.config} asks for a leg twice; read each once.")
    if pose.aimed_mm is not None and len(pose.aimed_mm) != len(pose.legs):
        raise PlanRefusedError(f"Pose {pose.config} must give an aimed length for each of its legs.")


def _check_joints(
    what: str,
    stops_rad: Sequence[Sequence[float]],
    n_joints: int,
    limits: tuple[JointRange, ...] | None,
) -> None:
    for joints in stops_rad:
        if len(joints) != n_joints:
            raise PlanRefusedError(
                f"{_sentence(what)} has {len(joints)} joint angles, the robot has {n_joints} joints."
            )
        for number, (angle, limit) in enumerate(zip(joints, limits or (), strict=False), 1):
            if not limit.lower_rad <= angle <= limit.upper_rad:
                raise PlanRefusedError(f"{_sentence(what)} is outside the range of joint {number}.")


def _sentence(what: str) -> str:
    return what[0].upper() + what[1:]
