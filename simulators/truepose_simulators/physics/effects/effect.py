"""What a physical effect may know and do to the arm, and how it reads its subject and its details.

Parameters are in mm, rad, s, h, N and kg.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from truepose_simulators.errors import ModelError, ScenarioError
from truepose_simulators.physics.arm import Arm, Bodies, CarriedMass, Vector
from truepose_simulators.physics.loads import GRAVITY_M_S2, PlacedMass
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.physics.table_arm import TableRow
from truepose_simulators.scenarios.table import read_table


@dataclass(frozen=True, slots=True)
class Conditions:
    """The circumstances of n stops; everything but the loads, which only the equilibrium tells."""

    joints_rad: FloatArray  # (n, J) commanded
    direction: FloatArray  # (n, J) sign of each joint's last motion, 0 unknown
    time_s: FloatArray  # (n,) cell time
    temperature_c: FloatArray  # (n,)
    attachment: FloatArray  # (n,) how often the tool has been mounted
    # (n, J) what torque sensors said; None: gravity alone loads the gearboxes
    measured_torque_n_mm: FloatArray | None = None

    def __len__(self) -> int:
        return int(self.joints_rad.shape[0])

    def since(self, from_s: float) -> FloatArray:
        """1 where a change that begins at `from_s` is there, else 0; shape (n,)."""
        return since(self.time_s, from_s)


def since(time_s: FloatArray, from_s: float) -> FloatArray:
    """1 from `from_s` on, else 0."""
    return (time_s >= from_s).astype(np.float64)


@dataclass(frozen=True, slots=True)
class Loads:
    """What gravity does at the configuration as it truly is; nothing before the arm has been placed once."""

    torque_n_mm: FloatArray  # (n, J) about each axis, positive along it
    masses: tuple[PlacedMass, ...] = ()
    bodies: Bodies | None = None
    gravity_m_s2: Vector = GRAVITY_M_S2  # world


@dataclass(frozen=True, slots=True)
class Deflection:
    """What an effect adds: to the angles of the joints, and to the motions of base, links and tool."""

    angles_rad: FloatArray | None = None  # (n, J)
    motions: FloatArray | None = None  # (n, J+2, 6) [mm, rad], seats as in `arm.link_motions`

    @classmethod
    def of_joint(cls, conditions: Conditions, joint: int, angle_rad: FloatArray) -> "Deflection":
        """Turn one joint (0-based) by `angle_rad`, shape (n,)."""
        angles = np.zeros_like(conditions.joints_rad)
        angles[:, joint] = angle_rad
        return cls(angles_rad=angles)

    @classmethod
    def of_body(cls, conditions: Conditions, body: int, motion: FloatArray) -> "Deflection":
        """Move one body (0 base, then the links, -1 tool) by `motion`, shape (n, 6) [mm, rad]."""
        n, n_joints = conditions.joints_rad.shape
        motions = np.zeros((n, n_joints + 2, 6))
        motions[:, body] = motion
        return cls(motions=motions)


@dataclass(frozen=True, slots=True)
class PlantedChange:
    """A change planted in the cell, as a scenario names it; what `details` may say is up to the effect."""

    name: str
    subject: str
    amplitude: float
    from_s: float = 0.0
    details: Mapping[str, object] = field(default_factory=dict)


T = TypeVar("T")


@dataclass(frozen=True)
class Site:
    """One cell, as far as effects care."""

    arm: Arm
    compliance_rad_per_n_mm: FloatArray  # (J,) of the true gearboxes
    tool_mass: CarriedMass | None  # as stated
    n_nests: int  # on the tool
    reference_c: float  # temperature at which lengths are what the plant says
    entropy: tuple[int, ...]  # decides what the change leaves to chance

    def rng(self, *stream: int) -> np.random.Generator:
        """Source of what is left to chance; the same stream always gives the same numbers."""
        return np.random.default_rng([*self.entropy, *stream])


@dataclass(frozen=True, slots=True)
class NoDetails:
    """Of an effect that subject and amplitude describe in full."""


def read_details(cls: type[T], change: PlantedChange) -> T:
    """Read the details of a change into the dataclass `cls`; raises ScenarioError."""
    return read_table(cls, change.details, f"effect {change.name}")


def joint_index(change: PlantedChange, arm: Arm) -> int:
    """0-based joint of a subject such as "joint 3"; raises ScenarioError."""
    return joint_named(change.subject, change, "subject", arm)


def joint_named(text: str, change: PlantedChange, key: str, arm: Arm) -> int:
    """0-based joint of a text such as "joint 3" at `key` of the change; raises ScenarioError."""
    number = _number(text, "joint")
    if number is None or number > arm.n_joints:
        raise _refusal(change, key, text, f'"joint 1" to "joint {arm.n_joints}"')
    return number - 1


def joint_indices(change: PlantedChange, arm: Arm) -> tuple[int, ...]:
    """0-based joints of "joint 3" (one) or "joints" (all); raises ScenarioError."""
    if change.subject == "joints":
        return tuple(range(arm.n_joints))
    number = _number(change.subject, "joint")
    if number is None or number > arm.n_joints:
        raise _refusal(change, "subject", change.subject, f'"joint 1" to "joint {arm.n_joints}" or "joints"')
    return (number - 1,)


def link_numbers(change: PlantedChange, known: tuple[int, ...]) -> tuple[int, ...]:
    """Links of "link 2" (one) or "links" (all `known`), 1-based; raises ScenarioError."""
    if change.subject == "links":
        return known
    number = _number(change.subject, "link")
    if number not in known:
        names = ", ".join(f'"link {link}"' for link in known)
        raise _refusal(change, "subject", change.subject, f'{names} or "links"')
    return (number,)


def nest_index(change: PlantedChange, n_nests: int) -> int:
    """0-based nest of a subject such as "nest 3"; raises ScenarioError."""
    number = _number(change.subject, "nest")
    if number is None or number > n_nests:
        raise _refusal(change, "subject", change.subject, f'"nest 1" to "nest {n_nests}"')
    return number - 1


def placement_number(change: PlantedChange) -> int:
    """Return the number of a subject such as "placement 2"; raises ScenarioError."""
    number = _number(change.subject, "placement")
    if number is None:
        raise _refusal(change, "subject", change.subject, '"placement 1" or another of the base fixture')
    return number


def nest_pair(change: PlantedChange, n_nests: int) -> tuple[int, int]:
    """Both nests of "nest 1, nest 2", ascending, 1-based; raises ScenarioError."""
    numbers = [_number(part, "nest") for part in change.subject.split(", ")]
    match numbers:
        case [int(first), int(second)] if first < second <= n_nests:
            return first, second
    raise _refusal(
        change, "subject", change.subject, f'two of the {n_nests} nests, ascending, such as "nest 1, nest 2"'
    )


def check_only(change: PlantedChange, subject: str) -> None:
    """Raise ScenarioError unless the change is about `subject`, the only thing that it can be about."""
    if change.subject != subject:
        raise _refusal(change, "subject", change.subject, f'"{subject}"')


def check_one_of(change: PlantedChange, *subjects: str) -> None:
    """Raise ScenarioError unless the change is about one of `subjects`."""
    if change.subject not in subjects:
        raise _refusal(change, "subject", change.subject, " or ".join(f'"{name}"' for name in subjects))


def _number(text: str, kind: str) -> int | None:
    match = re.fullmatch(rf"{kind} ([1-9][0-9]{{0,3}})", text)
    return None if match is None else int(match[1])


def _refusal(change: PlantedChange, key: str, text: str, allowed: str) -> ScenarioError:
    return ScenarioError(f'effect {change.name}: {key} "{text}" must be {allowed}')


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
class IdentifiedEffect:
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
            raise ModelError(f"effect {self.effect}: there is no {what} {number}; there are {count}")
        return int(number) - 1

    def unknown(self, name: str, form: str) -> ModelError:
        """Return what to raise for a parameter that this physics has no meaning for."""
        return ModelError(
            f'effect {self.effect}: the simulator has no parameter "{name}", only {form}; write the model'
            " again with the truepose version of this simulator"
        )

    def _vectors(self, pattern: str, form: str, components: tuple[str, ...]) -> dict[str, FloatArray]:
        found: dict[str, FloatArray] = {}
        axes = "|".join(components)
        for (owner, axis), value in self.matching(rf"{pattern}_({axes})", f"{form}_{axes}"):
            vector = found.setdefault(owner, np.zeros(len(components)))
            vector[components.index(axis)] = value
        return found
