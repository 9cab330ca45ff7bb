"""Backlash: a joint stops short of where it is sent, by half of its gap, whichever way it comes.

    theta_i moves by  -sign_i dir_i gap_i / 2        dir = +1, -1 the joint's last motion, 0 unknown

The angle, as the controller counts it, is off by -gap / 2 times the direction of the joint's last motion.
Where the direction is unknown the joint is taken to stand in the middle of its gap.

Source of the size of gaps: thesis of A. Nubiola, 2014, table 2.3. The thesis removes backlash instead, by
coming to all configurations from one side (section 2.4).
"""

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import (
    FEWEST_TOGETHER,
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    Scene,
    Signature,
)
from truepose.effects.names import joint_name, joint_of, joint_subject
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "backlash"
_WIDTH_RAD = np.deg2rad(0.1)  # belief: three times the widest gap of the thesis (table 2.3)
_FEWEST_EACH_WAY = 4  # stops from either side without which a gap is hardly more than a reading's error


class Backlash:
    """One backlash per joint."""

    name = NAME
    needs: frozenset[Need] = frozenset({"direction"})
    traits = frozenset({Trait.STEADY, Trait.AGEING})
    signature = Signature(
        OF_SUBJECT,
        "direction",
        "sign",
        "full difference between the two directions of approach",
        plural="joints",
        drawn="joint",
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return one gap per joint."""
        # Joint 1 too: the base takes its zero, but no parameter of the base follows from which side it came.
        return tuple(_spec(joint) for joint in range(setting.robot.n_joints))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn each joint back by half of its gap: weight -sign dir / 2 [rad/rad] on its theta."""
        joints = [joint_of(name) for name in names]
        return [Term(k, Port(PortKind.THETA, j), _short_of(rows, j)) for k, j in enumerate(joints)]

    def unmodelled(self, setting: Setting, stops: Stops) -> bool:
        """Say that it may be, where some joint came from both sides: from one side a gap is an offset."""
        return stops.direction is not None and bool(from_both_sides(stops.direction))

    def unseen(self, scene: Scene) -> Text | None:
        """Need stops that were approached from both sides."""
        if scene.stops.direction is None:
            return message("unseen.no_direction")
        if not from_both_sides(scene.stops.direction):
            return message("unseen.one_direction")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each joint that came from both sides, and all of them together."""
        # A joint that came from one side has a gap as well, but all of it is in the zero of that joint.
        joints = [] if scene.stops.direction is None else from_both_sides(scene.stops.direction)
        specs = [spec for spec in map(_spec, joints) if spec.name not in scene.present]
        found = [Candidate(NAME, joint_subject(joint_of(spec.name)), (spec,)) for spec in specs]
        # Six small gaps may each be below what a search of one joint finds, and together well above it.
        if len(specs) >= FEWEST_TOGETHER:
            found.append(Candidate(NAME, "joints", tuple(specs)))
        return tuple(found)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how wide the gap is; of several joints the widest, with the others in the details."""
        gaps, spreads = np.rad2deg(fitted.values), np.rad2deg(np.sqrt(np.diag(fitted.covariance)))
        widest = int(np.abs(gaps).argmax())
        which = joint_subject(joint_of(fitted.names[widest]))
        gap_deg = abs(float(gaps[widest]))
        if len(gaps) == 1:
            # A gap below zero is told as it is, as a joint that goes past its place: the sentence of a gap
            # would be wrong.
            key = "causes.backlash.short" if gaps[widest] >= 0.0 else "causes.backlash.past"
            sentence = message(key, joint=which, gap_deg=gap_deg)
            details: tuple[Detail, ...] = ()
        else:
            sentence = message("causes.backlash.several", joint=which, gap_deg=gap_deg)
            details = tuple(
                Detail(f"gap of {joint_subject(joint_of(name))}", float(gap), "deg", float(spread))
                for name, gap, spread in zip(fitted.names, gaps, spreads, strict=True)
            )
        return Description(subject, float(gaps[widest]), "deg", float(spreads[widest]), sentence, details)


def _spec(joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name("gap", joint), "rad", 0.0, _WIDTH_RAD)


def _short_of(rows: Rows, joint: int) -> FloatArray:
    """Return -sign dir / 2 of each row, shape (n,); zeros where no direction is known."""
    if rows.stops.direction is None:
        return np.zeros(len(rows.stops))
    # Directions are counted as the controller counts angles, the port moves theta: hence the joint's sign.
    return -0.5 * rows.robot.joints[joint].sign * np.sign(rows.stops.direction[:, joint])


def from_both_sides(direction: IntArray) -> list[int]:
    """Return the joints (0-based) that came to stops enough from either side.

    Parameters
    ----------
    direction : ndarray of int, shape (n, J)
        Signs of last motions, 0 where unknown.
    """
    forth, back = (direction > 0).sum(axis=0), (direction < 0).sum(axis=0)
    return np.flatnonzero(np.minimum(forth, back) >= _FEWEST_EACH_WAY).tolist()
