"""Targets that are not meant as they are read: in another unit, frame or order of numbers.

A robot is corrected for where it works. Where targets lie beyond its reach or far from where it was measured,
and read in another way that is often the right one they would not, that way is named.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from truepose.correction.branches import NominalArm
from truepose.correction.joint_targets import numbered_nests, with_flange
from truepose.correction.target_poses import Goals
from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.identification import Model
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.model.validity import beyond_zone_mm
from truepose.kinematics.frames import quaternion_from_rotation, rotation_from_quaternion
from truepose.messages.message import Message, message

_FEWEST: Final = 3  # targets: of fewer nothing is said
_LOOKED_AT: Final = 500  # of a table, evenly drawn
_NEAR_MM: Final = 100.0  # from the measured zone
_SPREAD_MM: Final = 3.0  # what lies within is the origin of a frame, to which small numbers shrink
_OWN_BODY: Final = 0.1  # of the length of all links: nearer to its origin the robot's base itself stands
_NEARLY_ALL: Final = 0.95
_SOME: Final = 0.25  # of the targets that another reading explains: more are not left unexplained by chance
_LENGTHS: Final = {"metres": 1000.0, "inches": 25.4, "centimetres": 10.0, "micrometres": 1e-3}
_MEANT: Final = {
    "metres": "corrections.mistake.metres",
    "inches": "corrections.mistake.inches",
    "centimetres": "corrections.mistake.centimetres",
    "micrometres": "corrections.mistake.micrometres",
    "world": "corrections.mistake.world",
    "base": "corrections.mistake.base",
    "scalar_last": "corrections.mistake.scalar_last",
    "turned_back": "corrections.mistake.turned_back",
    "inverse": "corrections.mistake.inverse",
    "mirrored": "corrections.mistake.mirrored",
}
OTHER_READINGS: Final = frozenset(_MEANT.values())  # keys of sentences that name one
_MIRROR: Final = np.diag([1.0, -1.0, 1.0])


def likely_mistake(model: Model, goals: Goals, *, in_base: bool) -> Message | None:
    """Return as what targets were probably meant; None where as they are, or as nothing that is known.

    Parameters
    ----------
    model : Model
    goals : Goals
        n poses as they were given.
    in_base : bool
        Whether in the robot's base, else in the world.

    Returns
    -------
    Message or None
        A sentence that names the other reading, or how far all targets lie from where the robot was measured.
    """
    if len(goals) < _FEWEST:
        return None
    # A few hundred tell a share to some per cent; each reading of the table is a closed form of its own.
    every = max(len(goals) // _LOOKED_AT, 1)
    looked_at = replace(goals, nest=numbered_nests(model, goals.nest)).taken(np.arange(0, len(goals), every))
    work = _Work(model)
    now = work.share(looked_at, in_base=in_base)
    # What is in place as it is read needs no other reading, however many others would fit as well.
    if now >= _NEARLY_ALL:
        return None
    shares = {name: work.share(other, in_base=base) for name, other, base in _readings(looked_at, in_base)}
    name = max(shares, key=lambda one: shares[one])
    # The best of them alone is named, and only where it explains nearly all or where hardly any are in place
    # as read.
    if _explains(shares[name], now):
        return message(_MEANT[name], now=now, then=shares[name])
    away_mm = work.away_mm(looked_at, in_base=in_base)
    # A few that are in place may be all that was meant, and the others new places: nothing is said then.
    return None if now or not away_mm else message("corrections.mistake.elsewhere", away_mm=away_mm)


def _explains(then: float, now: float) -> bool:
    """Say whether a reading that puts that share of targets in place speaks against the one that puts `now`.

    Parameters
    ----------
    then, now : float
        Shares in 0..1.
    """
    if now <= _SOME * then:
        return then >= 0.5
    return then >= _NEARLY_ALL and now <= 1.0 - _SOME


def _readings(goals: Goals, in_base: bool) -> Iterator[tuple[str, Goals, bool]]:
    """Yield names of other ways to read targets, and what they come to."""
    rotation, back = goals.rotation, np.swapaxes(goals.rotation, 1, 2)
    for unit, length in _LENGTHS.items():
        yield unit, replace(goals, position_mm=length * goals.position_mm), in_base
    yield ("world" if in_base else "base"), goals, not in_base
    yield "scalar_last", replace(goals, rotation=_scalar_last(rotation)), in_base
    yield "turned_back", replace(goals, rotation=back), in_base
    inverse = -np.einsum("nij,nj->ni", back, goals.position_mm)
    yield "inverse", replace(goals, position_mm=inverse, rotation=back), in_base
    mirrored = goals.position_mm @ _MIRROR
    yield "mirrored", replace(goals, position_mm=mirrored, rotation=_MIRROR @ rotation @ _MIRROR), in_base


def _scalar_last(rotation: FloatArray) -> FloatArray:
    """Return the rotations of quaternions whose real part stands last, though it was read as the first.

    The quaternion that was read is rolled by one place; shapes (n, 3, 3).
    """
    return rotation_from_quaternion(np.roll(quaternion_from_rotation(rotation), 1, axis=1))


class _Work:
    """Where a robot works: within its reach, and near where it was measured."""

    def __init__(self, model: Model) -> None:
        self._zone = model.zone
        self._own_mm = _OWN_BODY * sum(float(np.hypot(row.a_mm, row.d_mm)) for row in model.robot.joints)
        self._arm = NominalArm(with_flange(identified_estimate(model)))

    def share(self, goals: Goals, *, in_base: bool) -> float:
        """Return the share of targets that lie where the robot works: in 0..1.

        Parameters
        ----------
        goals : Goals
            n of them, nests numbered as of `with_flange`.
        in_base : bool
        """
        flange = self._arm.flange(self._arm.in_world(goals) if in_base else goals)
        place = flange[:, :3, 3]
        # In metres read as millimetres a whole work space is a point; it may lie anywhere, so no place is
        # credited.
        if float(np.ptp(place, axis=0).max()) < _SPREAD_MM:
            return 0.0
        # Numbers that shrink end at the origin of their frame, which is in the robot's own column: within the
        # reach of its nominal arm, and yet no place to work.
        apart = np.linalg.norm(place, axis=1) > self._own_mm
        return float((apart & self._reached(flange) & self._near(flange)).mean())

    def away_mm(self, goals: Goals, *, in_base: bool) -> float | None:
        """Return how far from the measured zone the nearest target lies.

        Parameters
        ----------
        goals : Goals
            n of them, nests numbered as of `with_flange`.
        in_base : bool

        Returns
        -------
        float or None
            [mm]; 0 within the zone, None where nobody said where that is.
        """
        if self._zone is None:
            return None
        flange = self._arm.flange(self._arm.in_world(goals) if in_base else goals)
        return float(beyond_zone_mm(self._zone, flange[:, :3, 3]).min())

    def _reached(self, flange: FloatArray) -> BoolArray:
        """Say which poses (n, 4, 4) the nominal arm reaches; all, where only a search could tell."""
        if not self._arm.has_branches:
            return np.ones(len(flange), dtype=bool)  # a search would take longer than the correction
        angle_1 = self._arm.branches(flange, reach_out=False)[..., 0]
        return np.asarray(np.isfinite(angle_1).any(axis=1))

    def _near(self, flange: FloatArray) -> BoolArray:
        """Say which poses (n, 4, 4) are within 100 mm of the measured zone; all, where nobody said it."""
        if self._zone is None:
            return np.ones(len(flange), dtype=bool)
        return np.asarray(beyond_zone_mm(self._zone, flange[:, :3, 3]) <= _NEAR_MM)
