"""The procedure of a tracker session as generators of steps: nothing here waits, moves or measures.

The manner is that of A. Nubiola's thesis (2014), sections 2.2 and 2.4: approach every configuration
from the same side, 4 s of rest, the world frame from fixed nests.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from truepose.domain.session import PlannedStop, SessionPlan
from truepose.sequencing.tracker.steps import (
    CheckFaces,
    CheckReferences,
    FindReflector,
    LocateFixedNests,
    MeasurePoint,
    Move,
    OpenDevices,
    ReadFixedNest,
    ReadJoints,
    Register,
    Section,
    Settle,
    Step,
)

_FACE_READINGS = 5  # the mean of five scatters by 0.007 mm at 2.5 m: small against a two-face limit of 0.1 mm


def session_sections(
    plan: SessionPlan, n_fixed_nests: int, *, registered: bool = False, done: Collection[int] = ()
) -> Iterator[Section]:
    """Yield all sections of a session in order.

    `done` are numbers of configurations that earlier runs measured or skipped; a session that is
    `registered` already only looks at its fixed nests again, to see that nothing moved meanwhile.
    """
    yield opening()
    if not registered:
        yield registration(plan, n_fixed_nests)
    yield references(n_fixed_nests)
    yield from visits(plan, plan.stops, n_fixed_nests, done)


def visits(
    plan: SessionPlan, stops: Sequence[PlannedStop], n_fixed_nests: int, done: Collection[int] = ()
) -> Iterator[Section]:
    """Yield the sections that measure `stops`, with looks at the fixed nests among them and at the end."""
    for index, stop in enumerate(stops, start=1):
        if stop.config in done:
            continue
        yield visit(plan, stop)
        if index % plan.reference_every == 0 and index < len(stops):
            yield references(n_fixed_nests)
    yield references(n_fixed_nests)


def extended_plan(plan: SessionPlan, stops: tuple[PlannedStop, ...]) -> SessionPlan:
    """Return the plan with more stops at its end."""
    return replace(plan, stops=plan.stops + stops)


def numbers(stops: Sequence[PlannedStop]) -> str:
    """Return which configurations these stops are, in words."""
    first, last = stops[0].config, stops[-1].config
    return f"configuration {first}" if first == last else f"configurations {first} to {last}"


def opening() -> Section:
    """Return the section that makes the instruments ready."""
    return Section("making the instruments ready", (OpenDevices(),))


def registration(plan: SessionPlan, n_fixed_nests: int) -> Section:
    """Return the section that finds the tracker's place in the world."""
    return Section("finding the tracker's place in the world", tuple(_registration(plan, n_fixed_nests)))


def _registration(plan: SessionPlan, n_fixed_nests: int) -> Iterator[Step]:
    yield LocateFixedNests()
    if plan.two_face_check:
        yield ReadFixedNest(1, "two_face", face=1, readings=_FACE_READINGS)
        yield ReadFixedNest(1, "two_face", face=2, readings=_FACE_READINGS)
        yield CheckFaces()
    for nest in range(1, n_fixed_nests + 1):
        yield ReadFixedNest(nest, "registration", face=1, readings=plan.registration_readings)
    yield Register()


def references(n_fixed_nests: int) -> Section:
    """Return the section that looks whether anything moved since the registration."""
    nests = range(1, n_fixed_nests + 1)
    looks = tuple(ReadFixedNest(nest, "reference", face=1, readings=1) for nest in nests)
    return Section("looking at the fixed nests", (*looks, CheckReferences()))


def visit(plan: SessionPlan, stop: PlannedStop) -> Section:
    """Return the section that measures one configuration."""
    return Section(f"measuring configuration {stop.config}", tuple(_visit(plan, stop)), stop)


def _visit(plan: SessionPlan, stop: PlannedStop) -> Iterator[Step]:
    if plan.approach_offset_rad is not None:
        yield Move(approach_target(stop.joints_rad, plan.approach_offset_rad), approach=True)
    yield Move(stop.joints_rad, approach=False)
    yield Settle(plan.settle_s)
    yield ReadJoints(stop.joints_rad)
    yield FindReflector(stop)
    yield MeasurePoint(stop)


def approach_target(joints_rad: tuple[float, ...], offset_rad: float) -> tuple[float, ...]:
    """Return where the last motion to a stop begins, the same offset away on all joints."""
    return tuple(joint + offset_rad for joint in joints_rad)
