"""What is being identified: nominal robot, start placement, parameters of effects, anchors and targets.

Parameters p are numbered once: effects in their order, then anchors and offset of legs, or targets of
contacts; what is added to a structure later comes last. An effect says by terms (parameter, port, weight) how
they act; a port is moved by

    t = sum over its terms of weight * p[parameter]        weight a number, or one for each of n rows

Base and tool start at rotations R_start, about which they turn by three angles:

    R = RotX(rx) RotY(ry) RotZ(rz) R_start

so that near the start the angles are small and none of them locks.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin
from typing import TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.contacts import Target
from truepose.domain.robot import Robot
from truepose.effects.ports import ParameterSpec, Port, PortKind, Rows, Term, Trait
from truepose.effects.registry import effect_named, effects_with, summed_effects
from truepose.kinematics.frames import rotation_xyz

NOMINAL_EFFECTS = effects_with(Trait.PLACING)  # what is fitted around the nominal model


@dataclass(frozen=True)  # without slots: what follows from the parameters is kept once it was asked for
class Structure:
    """A model without values: where it starts and which parameters move it.

    `anchors` are unknown base nests of legs, named `anchor_<placement>_<point>_x`..; they and the
    offset of the length come after the effects' parameters.

    Attributes
    ----------
    robot : Robot
        Nominal.
    base_rotation : ndarray, shape (3, 3)
        Start; of the base in the world.
    base_origin_mm : ndarray, shape (3,)
        Start; in the world.
    nests_mm : ndarray, shape (K, 3)
        Start; flange frame, nest k in row k - 1.
    tool_rotation : ndarray, shape (3, 3)
        Start; of the tool in the flange frame.
    gravity_m_s2 : ndarray, shape (3,)
        In the world.
    effects : tuple of str
    specs : tuple of ParameterSpec, length P
        Names, internal units, prior means and widths.
    owners : tuple of str, length P
        Effect of each parameter.
    anchors : tuple of (placement, base point)
    targets : tuple of Target
        Of contacts, whose parameters `target_<number>_..` come last too.
    instrument_mm : ndarray, shape (3,), optional
        Place of the instrument in the world.
    torques_measured : bool
        Whether springs are loaded by measured torques, not by gravity's.
    origin_s : float
        Time from which drifts and warm-ups count.
    last_s : float, optional
        Time of the last of the readings that a model was made from; None while it is made.
    """

    robot: Robot
    base_rotation: FloatArray
    base_origin_mm: FloatArray
    nests_mm: FloatArray
    tool_rotation: FloatArray
    gravity_m_s2: FloatArray
    effects: tuple[str, ...]
    specs: tuple[ParameterSpec, ...]
    owners: tuple[str, ...]
    anchors: tuple[tuple[int, int], ...] = ()
    targets: tuple[Target, ...] = ()
    instrument_mm: FloatArray | None = None
    torques_measured: bool = False
    origin_s: float = 0.0
    last_s: float | None = None

    @property
    def has_springs(self) -> bool:
        """Whether an effect of it yields to the torque on each joint."""
        return not set(effects_with(Trait.SPRINGS)).isdisjoint(self.effects)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(spec.name for spec in self.specs)

    @cached_property
    def prior_means(self) -> FloatArray:
        """Prior means, shape (P,)."""
        return np.array([spec.prior_mean for spec in self.specs])

    @cached_property
    def prior_widths(self) -> FloatArray:
        """Prior standard deviations, shape (P,)."""
        return np.array([spec.prior_width for spec in self.specs])

    def indices_of(self, effect: str) -> tuple[int, ...]:
        """Return the indices of the parameters of one effect."""
        return self._members.get(effect, ())

    def names_of(self, effect: str) -> tuple[str, ...]:
        """Return the names of the parameters of one effect."""
        return self._member_names.get(effect, ())

    @cached_property
    def _members(self) -> Mapping[str, tuple[int, ...]]:
        # Owners need not follow one another: what a diagnosis adds to an effect comes at the end.
        return {
            effect: tuple(k for k, owner in enumerate(self.owners) if owner == effect)
            for effect in dict.fromkeys(self.owners)
        }

    @cached_property
    def _member_names(self) -> Mapping[str, tuple[str, ...]]:
        return {effect: tuple(self.names[k] for k in members) for effect, members in self._members.items()}

    def index_of(self, name: str) -> int:
        """Return the index of a parameter."""
        return self._places[name]

    @cached_property
    def _places(self) -> Mapping[str, int]:
        return {name: place for place, name in enumerate(self.names)}

    def extended(self, effect: str, specs: tuple[ParameterSpec, ...]) -> "Structure":
        """Return the structure with more parameters of an effect, at its end.

        Parameters
        ----------
        effect : str
            Their owner; added to the effects where it is none yet.
        specs : tuple of ParameterSpec
        """
        effects = self.effects if effect in self.effects else (*self.effects, effect)
        owners = (*self.owners, *(effect for _ in specs))
        return replace(self, effects=effects, specs=(*self.specs, *specs), owners=owners)

    def without(self, effects: tuple[str, ...]) -> "Structure":
        """Return the structure without the parameters of these effects."""
        # With a type, as an empty list of indices would be one of floats.
        left = np.array([k for k, owner in enumerate(self.owners) if owner not in effects], dtype=np.int64)
        return replace(self.kept(left), effects=tuple(name for name in self.effects if name not in effects))

    def kept(self, parameters: IntArray) -> "Structure":
        """Return the structure with some of its parameters, shape (p,) indices."""
        keep = parameters.tolist()
        return replace(
            self,
            specs=tuple(self.specs[k] for k in keep),
            owners=tuple(self.owners[k] for k in keep),
        )


def base_axes(start: FloatArray, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation RotX RotY RotZ * start, and the three axes about which its angles turn, in rows.

    Parameters
    ----------
    start : ndarray, shape (3, 3)
        Rotation at angles of 0.
    angles_rad : ndarray, shape (3,)
        rx, ry, rz.

    Returns
    -------
    rotation : ndarray, shape (3, 3)
    axes : ndarray, shape (3, 3)
        Unit vectors: x, then RotX y, then RotX RotY z, in the frame in which `start` is given.
    """
    # Written out for one rotation, not by `turned_axes` of rows: it is asked for in every evaluation.
    rx, ry, rz = angles_rad.tolist()
    axes = np.array([
        [1.0, 0.0, 0.0],
        [0.0, cos(rx), sin(rx)],
        [sin(ry), -sin(rx) * cos(ry), cos(rx) * cos(ry)],
    ])
    return rotation_xyz(rx, ry, rz) @ start, axes


LEG_OWNER = "legs"  # stands for these parameters where others name their effect
LEG_OFFSET = "length_offset"


def anchor_name(anchor: tuple[int, int], component: int) -> str:
    """Return e.g. `anchor_1_3_x` for placement 1, base point 3, component 0."""
    return f"anchor_{anchor[0]}_{anchor[1]}_{'xyz'[component]}"


def first_anchor(structure: Structure) -> int:
    """Return the index of the first coordinate of the base cups, which follow one another."""
    return structure.index_of(anchor_name(structure.anchors[0], 0))


def anchor_places(structure: Structure, values: FloatArray) -> FloatArray:
    """Return the places of the base cups at these values.

    Parameters
    ----------
    structure : Structure
        With A anchors.
    values : ndarray, shape (P,)

    Returns
    -------
    ndarray, shape (A, 3)
        [mm], world frame, in the order of `structure.anchors`.
    """
    first = first_anchor(structure)
    return np.asarray(values[first : first + 3 * len(structure.anchors)].reshape(-1, 3))


TARGET_OWNER = "targets"  # stands for these parameters where others name their effect
COUNTERPARTS = frozenset({LEG_OWNER, TARGET_OWNER})  # of what lengths are read against


def target_prefix(target: Target) -> str:
    """Return what the names of a target's parameters begin with, e.g. `target_2_`."""
    return f"target_{target.number}_"


def indices_of_target(structure: Structure, target: Target) -> slice:
    """Return where the parameters of a target stand, which follow one another."""
    # With its underscore at the end: target_1 is not the beginning of target_12.
    prefix = target_prefix(target)
    found = [k for k in structure.indices_of(TARGET_OWNER) if structure.names[k].startswith(prefix)]
    return slice(found[0], found[-1] + 1)


def certified_zeros(structure: Structure) -> frozenset[str]:
    """Return the names of the parameters that only stand for the uncertainty of a certificate."""
    # Nobody asks whether readings determine what a certificate has stated.
    return frozenset(
        f"{target_prefix(target)}zero" for target in structure.targets if target.zero_mm is not None
    )


def centre_of(structure: Structure, values: FloatArray, target: Target) -> FloatArray:
    """Return the centre of a target that has one.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (P,)
    target : Target
        One of the structure's: a sphere, the end of a wire or a ball.

    Returns
    -------
    ndarray, shape (3,)
        [mm], world frame.
    """
    return np.asarray(values[indices_of_target(structure, target)][:3])


Moved: TypeAlias = dict[Port, FloatArray | float]
Told: TypeAlias = Callable[[], tuple[Term, ...]]


class ActiveEffects:
    """The effects at the rows of one evaluation; those that no load changes are asked once."""

    def __init__(self, structure: Structure, values: FloatArray, rows: Rows) -> None:
        self.structure, self.values = structure, values
        self._rows = rows

    def under_load(self, rows: Rows) -> tuple[Told, Moved]:
        """Return terms and moved ports, gearboxes loaded by what effects add to the torque too.

        Parameters
        ----------
        rows : Rows
            n of them, with torques (n, J) [N mm] where they are known, and frames.

        Returns
        -------
        told : callable
            Gives all terms, where derivatives are asked for.
        moved : dict of Port to float or ndarray, shape (n,)
            By how much every port is moved, in its unit.
        """
        told, moved = self._at(rows)
        loads = [load for port, load in moved.items() if port.kind is PortKind.TORQUE]
        if rows.torque_n_mm is None or not any(np.any(load) for load in loads):
            return told, moved
        # Springs were asked at the bare torques above; once more, now that the added loads are known.
        return self._at(rows._replace(torque_n_mm=with_added_loads(rows.torque_n_mm, moved)))

    def _at(self, rows: Rows) -> tuple[Told, Moved]:
        following = [name for name in self.structure.effects if name not in effects_with(Trait.STEADY)]
        # The order of effects does not matter: what they move adds up.
        steady, already = self._steady
        told, moved = self._asked(following, rows, already)
        return lambda: (*steady(), *told()), moved

    @cached_property
    def _steady(self) -> tuple[Told, Moved]:
        # Balancing springs takes some passes; waves of gears would be worked out anew in each.
        steady = [name for name in self.structure.effects if name in effects_with(Trait.STEADY)]
        return self._asked(steady, self._rows, {})

    def _asked(self, effects: Sequence[str], rows: Rows, already: Moved) -> tuple[Told, Moved]:
        """Return what effects move; those that add up themselves tell their terms only if somebody asks."""
        # Sixty orders on six joints would be 720 columns of n rows where only their sum is wanted.
        summed = [name for name in effects if name in summed_effects()]
        terms = self._collected([name for name in effects if name not in summed], rows)
        moved = _moved(terms, self.values, already)
        for name in summed:
            values = self.values[list(self.structure.indices_of(name))]
            for port, shift in (
                summed_effects()[name].sums(self.structure.names_of(name), values, rows).items()
            ):
                moved[port] = moved.get(port, 0.0) + shift
        return lambda: (*terms, *self._collected(summed, rows)), moved

    def _collected(self, effects: Sequence[str], rows: Rows) -> tuple[Term, ...]:
        """Ask effects how their parameters act; parameter indices are those of the structure."""
        terms: list[Term] = []
        for effect in effects:
            indices = self.structure.indices_of(effect)
            terms += [
                Term(indices[term.parameter], term.port, term.weight)
                for term in effect_named(effect).terms(self.structure.names_of(effect), rows)
            ]
        return tuple(terms)


def _moved(terms: Iterable[Term], values: FloatArray, already: Moved) -> Moved:
    moved: defaultdict[Port, FloatArray | float] = defaultdict(float, already)
    # Not added in place: arrays of `already` are kept from pass to pass, and weights may be an effect's own.
    for term in terms:
        moved[term.port] = moved[term.port] + term.weight * float(values[term.parameter])
    return dict(moved)


def with_added_loads(torque: FloatArray, moved: Moved) -> FloatArray:
    """Return torques with the loads on ports added.

    Parameters
    ----------
    torque : ndarray, shape (n, J)
        [N mm]; left as it is.
    moved : dict of Port to float or ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n, J)
        [N mm]
    """
    # The bare torques stay: balance is judged by them.
    loaded = torque.copy()
    for port, load in moved.items():
        if port.kind is PortKind.TORQUE:
            loaded[:, port.number] += load
    return loaded
