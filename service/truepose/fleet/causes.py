"""What may change over months: directions in the parameters of a robot, and the scale of an instrument."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import Robot
from truepose.effects.names import joint_of, joint_subject
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.effects.waves import joint_of_wave, order_of_wave
from truepose.fleet.campaigns import GROWTH, SCALE, WAVES, Fleet

(JOINT_ZERO,) = effects_with(Trait.ZEROS)
_ZERO: Final = "theta"
_GROWN: Final = 1e-4  # of all lengths: five kelvin


@dataclass(frozen=True)
class AgeingCause:
    """One way in which a robot or an instrument may change.

    Attributes
    ----------
    effect : str
        Name of the effect that its parameters belong to.
    subject : str
        Joint, link or instrument, in words.
    directions : ndarray, shape (P + 1, q)
        In stated widths, the scale last.
    order : float
        Waves per turn; 0 of what is none.
    """

    effect: str
    subject: str
    directions: FloatArray
    order: float = 0.0

    @property
    def key(self) -> tuple[str, str, float]:
        """What tells it from every other cause."""
        return self.effect, self.subject, self.order


def robot_causes(fleet: Fleet, robot: Robot | None = None) -> tuple[AgeingCause, ...]:
    """Return what may change in a robot: each spring, gap, wave, zero and link.

    Parameters
    ----------
    fleet : Fleet
    robot : Robot, optional
        Nominal; with it, that all its lengths grow together is among the ways.

    Returns
    -------
    tuple of AgeingCause
        Parameters of one joint or link and effect together, in the order of the first of them.
    """
    members: dict[tuple[str, str, float], list[int]] = {}
    for place, (name, owner) in enumerate(zip(fleet.names, fleet.owners, strict=True)):
        if owner != GROWTH:  # a material does not change; that all lengths grow is a cause of its own
            members.setdefault(_kind(name, owner), []).append(place)
    found = [
        AgeingCause(effect, subject, _unit(fleet, places), order)
        for (effect, subject, order), places in members.items()
    ]
    grown = None if robot is None else _growth(fleet, robot)
    return tuple(found) if grown is None else (*found, AgeingCause(GROWTH, "links", grown))


def instrument_cause(fleet: Fleet) -> AgeingCause:
    """Return what may change in an instrument: its scale.

    Parameters
    ----------
    fleet : Fleet

    Returns
    -------
    AgeingCause
    """
    return AgeingCause(SCALE, "tracker", _unit(fleet, [len(fleet.specs)]))


def _kind(name: str, owner: str) -> tuple[str, str, float]:
    # The sine and the cosine of a wave are one cause: it may grow in any phase.
    if owner == WAVES:
        return owner, joint_subject(joint_of_wave(name)), order_of_wave(name)
    if owner not in effects_with(Trait.GEOMETRY):
        return owner, _subject(name), 0.0
    if name.startswith(_ZERO):
        return JOINT_ZERO, joint_subject(joint_of(name)), 0.0
    return owner, f"link {joint_of(name) + 1}", 0.0


def _subject(name: str) -> str:
    number = name.rsplit("_", 1)[-1]
    return f"joint {number}" if number.isdigit() else name


def _unit(fleet: Fleet, places: list[int]) -> FloatArray:
    return np.eye(len(fleet.specs) + 1)[:, places]


def _growth(fleet: Fleet, robot: Robot) -> FloatArray | None:
    """Return all lengths that are parameters, each by the same share of itself, shape (P + 1, 1).

    g l / w for a and d of length l and width w; None where no length is a parameter, or all are 0.
    """
    nominal: dict[str, Callable[[int], float]] = {
        "a": lambda joint: robot.joints[joint].a_mm,
        "d": lambda joint: robot.joints[joint].d_mm,
    }
    # The scale stays: an instrument that reads longer is a cause of its own, which this one is to be told
    # from.
    grown = np.zeros((len(fleet.specs) + 1, 1))
    for place, name in enumerate(fleet.names):
        quantity = name.split("_", 1)[0]
        if quantity in nominal:
            grown[place] = _GROWN * nominal[quantity](joint_of(name)) / fleet.widths[place]
    return grown if grown.any() else None
