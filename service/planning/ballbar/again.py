"""Poses aimed anew once a pre-calibration knows arm and cups better: coded lengths, order and ways."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from service.domain.ballbar import PlannedPose
from service.planning.ballbar.aiming import Lengths, aimed, aimed_pose
from service.planning.ballbar.bodies import BallbarCell
from service.planning.ballbar.fixture import BaseFixture
from service.planning.ballbar.motions import Stop, Surroundings
from service.planning.ballbar.tours import tour
from service.planning.errors import AimError

# An aim moves the tool by a millimetre or two, and so far the cups may be from where they were planned.
_ROOM_USED_MM: Final = 3.0


@dataclass(frozen=True, slots=True)
class AimedAgain:
    """Poses in the order in which they are to be measured."""

    poses: tuple[PlannedPose, ...]
    refusals: tuple[str, ...]  # one sentence for each pose that could not be coded, and what it does instead


def aimed_again(
    cell: BallbarCell,
    fixture: BaseFixture,
    poses: Sequence[PlannedPose],
    lengths: Callable[[PlannedPose], Lengths],
    here_rad: Sequence[float],
    *,
    seed: int = 0,
) -> AimedAgain:
    """Aim the poses of one placement at coded lengths under a model, and plan the ways between them.

    The codes are about the nominal length of the ballbar.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
        Of the placement of all these poses.
    poses : sequence of PlannedPose
        Those not measured yet, those skipped, those whose legs were exchanged.
    lengths : callable
        From a pose to the function that predicts the lengths of its legs, in their order.
    here_rad : sequence of float
        Where the arm is: the pose measured last.
    seed : int
        For the search for ways.

    Returns
    -------
    AimedAgain
        A pose that cannot be coded is aimed at nominal lengths, or stays as it was; none is lost.

    Raises
    ------
    NoWayError
        No clear way leads to one of them.
    """
    aims = [_aim(pose, lengths(pose), cell) for pose in poses]
    new = [pose for pose, _ in aims]
    around = Surroundings(replace(cell, arm_room_mm=cell.arm_room_mm - _ROOM_USED_MM), fixture)
    joints = np.array([pose.joints_rad for pose in new]).reshape(-1, cell.robot.n_joints)
    here = Stop(np.array(here_rad, dtype=float))
    order, vias = tour(around, joints, [list(range(len(new)))], here, np.random.default_rng(seed))
    ordered = tuple(replace(new[row], via_rad=via) for row, via in zip(order, vias, strict=True))
    return AimedAgain(ordered, tuple(refusal for _, refusal in aims if refusal is not None))


def _aim(pose: PlannedPose, lengths: Lengths, cell: BallbarCell) -> tuple[PlannedPose, str | None]:
    try:
        return aimed_pose(pose, lengths, cell.leg_mm, cell.ranges), None
    except AimError as refusal:
        sentence = str(refusal)
    try:
        joints = aimed(lengths, pose.joints_rad, np.full(len(pose.legs), cell.leg_mm), cell.ranges)
    except AimError:
        return replace(pose, aimed_mm=None), f"{sentence} It stays where it was planned."
    plain = replace(pose, joints_rad=tuple(float(q) for q in joints), aimed_mm=None)
    return plain, f"{sentence} It is aimed at lengths that are all nominal."
