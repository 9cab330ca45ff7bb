"""Where an effect may act. Each claims only what it does.

All are pure, so they can be asked again, but for labels and single readings: these draw from the generator
that they are given, and whoever asks again draws anew.
"""

from collections.abc import Sequence
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads
from truepose_simulators.physics.loads import MassChange
from truepose_simulators.physics.rigid import FloatArray

NestNumbers: TypeAlias = npt.NDArray[np.int_]


@runtime_checkable
class ArmEffect(Protocol):
    """Deflects joints, links, base or tool."""

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return what the effect adds under these conditions and loads."""


@runtime_checkable
class MassEffect(Protocol):
    """Makes masses other than stated."""

    def mass_changes(self, conditions: Conditions) -> Sequence[MassChange]:
        """Return what is there besides the stated masses."""


@runtime_checkable
class NestEffect(Protocol):
    """Moves nests on the tool."""

    def nest_offsets_mm(self, conditions: Conditions) -> FloatArray:
        """Return offsets in the flange frame, shape (n, nests, 3)."""


@runtime_checkable
class FrameEffect(Protocol):
    """Moves the instrument's frame."""

    def frame_motion(self, time_s: FloatArray) -> FloatArray:
        """Return `[tx ty tz rx ry rz]` [mm, rad] about the world's origin, shape (n, 6)."""


@runtime_checkable
class ScaleEffect(Protocol):
    """Stretches what the instrument reads."""

    def relative_scale(self, time_s: FloatArray) -> FloatArray:
        """Return by which share lengths are read too long, shape (n,)."""


@runtime_checkable
class LengthEffect(Protocol):
    """Stretches the lengths that a ballbar reads."""

    def relative_length(self, time_s: FloatArray) -> FloatArray:
        """Return by which share they are read too long, shape (n,)."""


@runtime_checkable
class ZeroEffect(Protocol):
    """Spoils the initialisation of a ballbar."""

    def zero_mm(self, initialisation: NestNumbers, since_s: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return by how much lengths are read too long `since_s` after an initialisation, shape (n,)."""


@runtime_checkable
class FixtureEffect(Protocol):
    """Moves a base fixture during its placement."""

    def fixture_motion(self, placement: NestNumbers, time_s: FloatArray) -> FloatArray:
        """Return `[tx ty tz rx ry rz]` [mm, rad] about the world's origin, shape (n, 6)."""


@runtime_checkable
class AirEffect(Protocol):
    """Warms the air of the cell."""

    def warming_k(self, time_s: FloatArray) -> FloatArray:
        """Return by how much it is warmer [K], shape (n,)."""


@runtime_checkable
class LabelEffect(Protocol):
    """Confuses the nests of the tool."""

    def nests_read(self, nest: NestNumbers, time_s: FloatArray, rng: np.random.Generator) -> NestNumbers:
        """Return which nests (1-based) were read under the labels `nest`, shape (n,)."""


@runtime_checkable
class ReadingEffect(Protocol):
    """Spoils single readings."""

    def displacement_mm(self, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return by how much each reading is off, shape (n, 3)."""


Effect: TypeAlias = (
    ArmEffect
    | MassEffect
    | NestEffect
    | FrameEffect
    | ScaleEffect
    | LengthEffect
    | ZeroEffect
    | FixtureEffect
    | AirEffect
    | LabelEffect
    | ReadingEffect
)
