"""The steps of a tracker session and the operations in them: nothing here waits, moves or measures.

The manner is that of A. Nubiola's thesis (2014), sections 2.2 and 2.4: approach every configuration
from the same side, 4 s of rest, the world frame from fixed nests.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose.domain.session import PlannedStop, SessionPlan, Work, stop_id
from truepose.messages.message import Message, Text, message

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
    StepKind.OPEN: message("session.doing.open"),
    StepKind.WARM: message("session.doing.warm"),
    StepKind.REGISTER: message("session.doing.register"),
    StepKind.LOOK: message("session.doing.look"),
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
    def title(self) -> Text:
        """What goes on, as the operator reads it."""
        if self.operations == (PlaceCamera(),):
            return message("session.doing.place_camera")
        if self.stop is None:
            return _TITLES[self.kind]
        works = self.stop.work is not None
        return message("session.doing.work" if works else "session.doing.measure", config=self.stop.config)


_BETWEEN_ROUNDS_S = 20.0  # of a warm-up that takes minutes
_FACE_READINGS = 5  # the mean of five scatters by 0.007 mm at 2.5 m: small against a two-face limit of 0.1 mm


def extended_plan(plan: SessionPlan, stops: tuple[PlannedStop, ...]) -> SessionPlan:
    """Return the plan with more stops at its end."""
    return replace(plan, stops=plan.stops + stops)


def numbers(stops: Sequence[PlannedStop]) -> Message:
    """Return which configurations these stops are, in words."""
    first, last = stops[0].config, stops[-1].config
    if first == last:
        return message("session.configuration", config=first)
    return message("session.configurations", first=first, last=last)


def opening() -> Step:
    """Return the step that makes the instruments ready."""
    return Step(StepKind.OPEN, (OpenDevices(),))


def warming(n_fixed_nests: int) -> Step:
    """Return the step that reads every fixed nest once more, to see how fast the tracker drifts."""
    nests = range(1, n_fixed_nests + 1)
    reads = (ReadFixedNest(nest, "warm_up", face=1, readings=1) for nest in nests)
    return Step(StepKind.WARM, (LocateFixedNests(anew=False), *reads, Settle(_BETWEEN_ROUNDS_S)))


def registration(plan: SessionPlan, n_fixed_nests: int) -> Step:
    """Return the step that finds the instrument's place in the world."""
    if plan.measures == "poses":
        return Step(StepKind.REGISTER, (PlaceCamera(),))
    return Step(StepKind.REGISTER, tuple(_registration(plan, n_fixed_nests)))


def _registration(plan: SessionPlan, n_fixed_nests: int) -> Iterator[Operation]:
    yield LocateFixedNests()
    # Before the registration: an instrument that is out of adjustment would be placed in the world with its
    # error.
    if plan.two_face_check:
        yield ReadFixedNest(1, "two_face", face=1, readings=_FACE_READINGS)
        yield ReadFixedNest(1, "two_face", face=2, readings=_FACE_READINGS)
        yield CheckFaces()
    for nest in range(1, n_fixed_nests + 1):
        yield ReadFixedNest(nest, "registration", face=1, readings=plan.registration_readings)
    yield Register()


def references(n_fixed_nests: int) -> Step:
    """Return the step that looks whether anything moved since the registration."""
    nests = range(1, n_fixed_nests + 1)
    looks = tuple(ReadFixedNest(nest, "reference", face=1, readings=1) for nest in nests)
    return Step(StepKind.LOOK, (*looks, CheckReferences()))


def visit(plan: SessionPlan, stop: PlannedStop) -> Step:
    """Return the step that measures one configuration."""
    return Step(StepKind.MEASURE, tuple(_visit(plan, stop)), stop)


def _visit(plan: SessionPlan, stop: PlannedStop) -> Iterator[Operation]:
    if stop.work is not None:
        yield KeepWorking(stop.work)
    begin_rad = stop.approach_rad(plan.approach_offset_rad)
    if begin_rad is not None:
        yield Move(begin_rad)
    yield Move(stop.joints_rad)
    yield Settle(plan.settle_s)
    # After the rest and before the reading: an arm that did not arrive must not have a reading kept for where
    # it was sent.
    yield ReadJoints(stop.joints_rad)
    if plan.measures == "poses":
        yield MeasurePose(stop)
    else:
        yield FindReflector(stop)
        yield MeasurePoint(stop)
