"""What is being identified: the nominal robot, its start placement and the parameters of its effects."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.targets import Target
from truepose.domain.robot import Robot
from truepose.effects.ports import ParameterSpec, Trait
from truepose.effects.registry import effects_with
from truepose.kinematics.frames import rotation_xyz

NOMINAL_EFFECTS = effects_with(Trait.PLACING)  # what is fitted around the nominal model


@dataclass(frozen=True)  # without slots: what follows from the parameters is kept once it was asked for
class Structure:
    """A model without values: where it starts and which parameters move it.

    `anchors` are unknown base nests of legs, named `anchor_<placement>_<point>_x`..; they and the
    offset of the length come after the effects' parameters.
    """

    robot: Robot
    base_rotation: FloatArray  # (3, 3) start
    base_origin_mm: FloatArray  # (3,) start
    nests_mm: FloatArray  # (K, 3) start, nest k in row k - 1
    tool_rotation: FloatArray  # (3, 3) start
    gravity_m_s2: FloatArray  # (3,)
    effects: tuple[str, ...]
    specs: tuple[ParameterSpec, ...]
    owners: tuple[str, ...]  # effect of each parameter
    anchors: tuple[tuple[int, int], ...] = ()  # (placement, base point)
    targets: tuple[Target, ...] = ()  # of contacts, whose parameters `target_<number>_..` come last too
    instrument_mm: FloatArray | None = None  # (3,) place of the instrument in the world
    torques_measured: bool = False  # springs are loaded by measured torques, not by gravity's
    origin_s: float = 0.0  # time from which drifts and warm-ups count
    last_s: float | None = None  # of the readings that a model was made from; None while it is made

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
        """Return the structure with more parameters of an effect, at its end."""
        effects = self.effects if effect in self.effects else (*self.effects, effect)
        owners = (*self.owners, *(effect for _ in specs))
        return replace(self, effects=effects, specs=(*self.specs, *specs), owners=owners)

    def without(self, effects: tuple[str, ...]) -> "Structure":
        """Return the structure without the parameters of these effects."""
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
    angles_rad : ndarray, shape (3,)

    Returns
    -------
    rotation : ndarray, shape (3, 3)
    axes : ndarray, shape (3, 3)
    """
    rx, ry, rz = angles_rad.tolist()
    axes = np.array([
        [1.0, 0.0, 0.0],
        [0.0, cos(rx), sin(rx)],
        [sin(ry), -sin(rx) * cos(ry), cos(rx) * cos(ry)],
    ])
    return rotation_xyz(rx, ry, rz) @ start, axes
