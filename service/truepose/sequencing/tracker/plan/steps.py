"""What a tracker session does: steps between checkpoints, each a row of operations; touches no device."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose.domain.measurement.session import PlannedStop, Work, stop_id

FixedNestPhase: TypeAlias = Literal["warm_up", "registration", "two_face", "reference"]


@dataclass(frozen=True, slots=True)
class OpenDevices:
    """Connect, identify and initialise the instruments; set the robot's speed."""


@dataclass(frozen=True, slots=True)
class LocateFixedNests:
    """Find out roughly where the fixed nests are in the tracker's frame."""

    anew: bool = True  # also where they have been found before


@dataclass(frozen=True, slots=True)
class ReadFixedNest:
    """Measure a fixed nest (1-based) so many times on one face of the tracker."""

    fixed_nest: int
    phase: FixedNestPhase
    face: Literal[1, 2]
    readings: int


@dataclass(frozen=True, slots=True)
class CheckFaces:
    """Compare the two faces of the tracker, from the readings just taken."""


@dataclass(frozen=True, slots=True)
class Register:
    """Compute the tracker's place in the world from the readings just taken."""


@dataclass(frozen=True, slots=True)
class CheckReferences:
    """Compare the readings just taken with where the fixed nests are certified to be."""


@dataclass(frozen=True, slots=True)
class Move:
    """Move all joints to a target and come to rest there."""

    target_rad: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class KeepWorking:
    """Move round and round until a stop is due."""

    work: Work


@dataclass(frozen=True, slots=True)
class Settle:
    """Let the arm come to rest."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class ReadJoints:
    """Ask the robot where it is and compare it with where it was sent."""

    expected_rad: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class FindReflector:
    """Point the tracker at the place where the nominal model expects the nest."""

    stop: PlannedStop


@dataclass(frozen=True, slots=True)
class MeasurePoint:
    """Measure the reflector, check the reading, store it."""

    stop: PlannedStop


@dataclass(frozen=True, slots=True)
class PlaceCamera:
    """Put the camera where the cell file says that it stands."""


@dataclass(frozen=True, slots=True)
class MeasurePose:
    """Measure the artefact's pose, check the reading, store it."""

    stop: PlannedStop


Operation: TypeAlias = (
    OpenDevices
    | LocateFixedNests
    | ReadFixedNest
    | CheckFaces
    | Register
    | CheckReferences
    | Move
    | KeepWorking
    | Settle
    | ReadJoints
    | FindReflector
    | MeasurePoint
    | PlaceCamera
    | MeasurePose
)


class StepKind(StrEnum):
    """What a step is for; all but the last are the names of their steps as well."""

    OPEN = "instruments"
    WARM = "warm-up"
    REGISTER = "world-frame"
    LOOK = "fixed-nests"
    MEASURE = "stop"


_TITLES: Final = {
    StepKind.OPEN: "making the instruments ready",
    StepKind.WARM: "waiting until the tracker drifts no more",
    StepKind.REGISTER: "finding the tracker's place in the world",
    StepKind.LOOK: "looking at the fixed nests",
}


@dataclass(frozen=True, slots=True)
class Step:
    """Operations between two checkpoints: after a pause or a lost link they are done again from the first."""

    kind: StepKind
    operations: tuple[Operation, ...]
    stop: PlannedStop | None = None  # the configuration that this step measures

    @property
    def id(self) -> str:
        """The name by which the ledger knows the step."""
        return self.kind.value if self.stop is None else stop_id(self.stop.config)

    @property
    def title(self) -> str:
        """What goes on, as the operator reads it."""
        if self.operations == (PlaceCamera(),):
            return "putting the camera where the cell file says that it stands"
        if self.stop is None:
            return _TITLES[self.kind]
        first = "" if self.stop.work is None else "working on, then "
        return f"{first}measuring configuration {self.stop.config}"
