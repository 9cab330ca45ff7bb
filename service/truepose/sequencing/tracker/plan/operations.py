"""The steps of a tracker session and the operations in them: nothing here waits, moves or measures.

The manner is that of A. Nubiola's thesis (2014), sections 2.2 and 2.4: approach every configuration
from the same side, 4 s of rest, the world frame from fixed nests.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.sequencing.tracker.plan.steps import (
    CheckFaces,
    CheckReferences,
    FindReflector,
    KeepWorking,
    LocateFixedNests,
    MeasurePoint,
    MeasurePose,
    Move,
    OpenDevices,
    Operation,
    PlaceCamera,
    ReadFixedNest,
    ReadJoints,
    Register,
    Settle,
    Step,
    StepKind,
)

_BETWEEN_ROUNDS_S = 20.0  # of a warm-up that takes minutes
_FACE_READINGS = 5  # the mean of five scatters by 0.007 mm at 2.5 m: small against a two-face limit of 0.1 mm


def extended_plan(plan: SessionPlan, stops: tuple[PlannedStop, ...]) -> SessionPlan:
    """Return the plan with more stops at its end."""
    return replace(plan, stops=plan.stops + stops)


def numbers(stops: Sequence[PlannedStop]) -> str:
    """Return which configurations these stops are, in words."""
    first, last = stops[0].config, stops[-1].config
    return f"configuration {first}" if first == last else f"configurations {first} to {last}"


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
    yield ReadJoints(stop.joints_rad)
    if plan.measures == "poses":
        yield MeasurePose(stop)
    else:
        yield FindReflector(stop)
        yield MeasurePoint(stop)
