"""Poses aimed anew once a pre-calibration knows arm and cups better: coded lengths, order and ways."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.measurement.ballbar import PlannedPose
from truepose.planning.ballbar.clear_ways.bodies import BallbarCell
from truepose.planning.ballbar.clear_ways.short_moves import Stop, Surroundings
from truepose.planning.ballbar.clear_ways.tours import tour
from truepose.planning.ballbar.fixture import BaseFixture
from truepose.planning.ballbar.lengths.aiming import Lengths, aimed, aimed_pose
from truepose.planning.errors import AimError

# An aim moves the tool by a millimetre or two, and so far the cups may be from where they were planned.
_ROOM_USED_MM: Final = 3.0


@dataclass(frozen=True, slots=True)
class AimedAgain:
    """Poses in the order in which they are to be measured."""

    poses: tuple[PlannedPose, ...]
    refusals: tuple[str, ...]  # a sentence for each that could not be coded, or to which no way leads


def aimed_again(
    cell: BallbarCell,
    fixture: BaseFixture,
    poses: Sequence[PlannedPose],
    lengths: Callable[[PlannedPose], Lengths],
    here_rad: Sequence[float],
    *,
    last: int | None = None,
    seed: int = 0,
) -> AimedAgain:
    """Aim the poses of one placement at coded lengths under a model, and plan the ways between them.

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
        Where the arm is.
    last : int, optional
        Configuration that stays the last one: where the arm waits while the base fixture is put elsewhere.
    seed : int
        For the search for ways.

    Returns
    -------
    AimedAgain
        A pose that cannot be coded is aimed at nominal lengths, or stays as it was. One to which no clear way
        leads is left out.
    """
    aims = [coded_or_kept(cell, pose, lengths(pose)) for pose in poses]
    new = [pose for pose, _ in aims]
    around = Surroundings(replace(cell, arm_room_mm=cell.arm_room_mm - _ROOM_USED_MM), fixture)
    joints = np.array([pose.joints_rad for pose in new]).reshape(-1, cell.robot.n_joints)
    groups = [
        [row for row, pose in enumerate(new) if pose.config != last],
        [row for row, pose in enumerate(new) if pose.config == last],
    ]
    found = tour(around, joints, groups, Stop(np.array(here_rad, dtype=float)), np.random.default_rng(seed))
    ordered = tuple(replace(new[row], via_rad=via) for row, via in zip(found.order, found.vias, strict=True))
    missed = (
        f"No clear way leads to configuration {new[row].config}: it is left out." for row in found.missed
    )
    return AimedAgain(ordered, (*(said for _, said in aims if said is not None), *missed))


def coded_or_kept(cell: BallbarCell, pose: PlannedPose, lengths: Lengths) -> tuple[PlannedPose, str | None]:
    """Return a pose at coded lengths, else at nominal ones, else as it was; and why it is not coded."""
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
