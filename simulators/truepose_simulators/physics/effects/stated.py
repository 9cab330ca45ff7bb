"""An effect as an identified model states it: its parameters by name, and the arm that they are about.

Parameters are in mm, rad, s, h, N and kg.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ModelError
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.physics.table_arm import TableRow

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
ALWAYS_S = -np.inf  # since when an identified effect acts, where it does not say itself


@dataclass(frozen=True)
class ModelArm:
    """The arm of an identified model, as far as its effects care."""

    arm: Arm
    rows: tuple[TableRow, ...]
    frames: FloatArray  # (J, 4, 4) of the joints at the zero configuration, base frame
    base: FloatArray  # (4, 4) base in the world
    n_nests: int  # on the tool
    origin_s: float  # time of the campaign at which the time of the physics is 0


@dataclass(frozen=True)
class Stated:
    """The parameters of one effect."""

    effect: str
    values: Mapping[str, float]

    def matching(self, pattern: str, form: str) -> Iterator[tuple[tuple[str, ...], float]]:
        """Yield the groups of `pattern` in every parameter's name, and its value.

        Raises ModelError for a name that does not fit; `form` says what would.
        """
        for name, value in self.values.items():
            match = re.fullmatch(pattern, name)
            if match is None:
                raise self.unknown(name, form)
            yield match.groups(), value

    def of_joints(self, quantity: str, arm: Arm) -> FloatArray:
        """Values of `<quantity>_<joint>`, 0 where none is stated, shape (J,)."""
        values = np.zeros(arm.n_joints)
        for (joint,), value in self.matching(rf"{quantity}_([0-9]+)", f"{quantity}_<joint>"):
            values[self.index(joint, arm.n_joints, "joint")] = value
        return values

    def motions(self, pattern: str, form: str) -> dict[str, FloatArray]:
        """Motions (6,) `<prefix>_x`..`<prefix>_rz` by what the one group of `pattern` finds in the prefix."""
        return self._vectors(pattern, form, COMPONENTS)

    def vectors(self, pattern: str, form: str) -> dict[str, FloatArray]:
        """Vectors (3,) `<prefix>_x`..`<prefix>_z` by what the one group of `pattern` finds in the prefix."""
        return self._vectors(pattern, form, COMPONENTS[:3])

    def index(self, number: str, count: int, what: str) -> int:
        """0-based index of a joint, link or nest (1-based in names); raises ModelError beyond `count`."""
        if not 1 <= int(number) <= count:
            raise ModelError(f"effect {self.effect}: there is no {what} {number}, there are {count}")
        return int(number) - 1

    def unknown(self, name: str, form: str) -> ModelError:
        """Return what to raise for a parameter that this physics has no meaning for."""
        return ModelError(
            f'effect {self.effect}: the simulated physics has no parameter "{name}", only {form}; write the'
            " model anew with the truepose of this simulator"
        )

    def _vectors(self, pattern: str, form: str, components: tuple[str, ...]) -> dict[str, FloatArray]:
        found: dict[str, FloatArray] = {}
        axes = "|".join(components)
        for (owner, axis), value in self.matching(rf"{pattern}_({axes})", f"{form}_{axes}"):
            vector = found.setdefault(owner, np.zeros(len(components)))
            vector[components.index(axis)] = value
        return found
