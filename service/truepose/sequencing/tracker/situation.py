"""The present situation of a tracker session: a pure function of its plan and its ledger.

The present step is the first that is due: instruments that are ready, a tracker whose place in the world is
known, fixed nests that were looked at lately, then the next stop that was neither measured nor skipped.
"""

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from truepose.domain.measurement.ledger import LedgerEntry
from truepose.domain.measurement.session import PlannedStop, Progress, Registration, SessionPlan
from truepose.sequencing.engine.by_itself import RunsByItself
from truepose.sequencing.engine.identity.expected import KnownDevice, same_number
from truepose.sequencing.tracker.plan import operations as plans
from truepose.sequencing.tracker.plan.steps import Step, StepKind
from truepose.sequencing.tracker.state_so_far import TrackerRecord
from truepose.sequencing.tracker.world_frame.warming import warmth


@dataclass(frozen=True, slots=True)
class TrackerSituation(RunsByItself):
    """Where a session stands."""

    step: Step | None  # the present one; None: nothing is left to do
    left: tuple[PlannedStop, ...]  # neither measured nor skipped
    unasked: tuple[PlannedStop, ...]  # of them: those to which nobody has let the arm go
    registration: Registration | None  # the tracker's place in the world, where it holds
    last_known: Registration | None  # or where it stood before
    measured_lately: bool
    failures: int
    paused_before: bool  # the present step made the session pause once
    interruptions: int  # of the present step
    since_first_s: float  # cell time from the first reading to the last line
    settled: bool  # what is left was left out, since drift has become slow
    progress: Progress


def situation(plan: SessionPlan, n_fixed_nests: int, entries: Iterable[LedgerEntry]) -> TrackerSituation:
    """Return where a session stands after these lines of its ledger, oldest first."""
    record = TrackerRecord()
    for entry in entries:
        record.apply(entry)
    return situation_of(plan, n_fixed_nests, record)


def situation_of(plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord) -> TrackerSituation:
    """Return where a session stands after what is on record."""
    ended = record.measured | record.skipped
    # What nobody has let the arm go to comes last: one question for all of it.
    open_stops = (stop for stop in plan.stops if stop.config not in ended)
    left = tuple(sorted(open_stops, key=lambda stop: stop.config not in record.allowed))
    settled = plan.ends_when_settled and _is_settled(record, left)
    if settled:
        left = ()
    step = present_step(plan, n_fixed_nests, record, left[0] if left else None)
    return TrackerSituation(
        state=record.state,
        reason=record.reason,
        step=step,
        left=left,
        unasked=tuple(stop for stop in left if stop.config not in record.allowed),
        registration=record.registration if _is_registered(record) else None,
        last_known=record.registration,
        measured_lately=record.measured_lately,
        failures=record.failures,
        paused_before=step is not None and step.id in record.paused_at,
        interruptions=0 if step is None else record.interruptions[step.id],
        progress=Progress(
            done=len(record.measured),
            skipped=len(record.skipped),
            planned=len(plan.stops),
            elapsed_s=record.times.elapsed_s,
            remaining_s=_remaining_s(plan, record, left),
            doing=record.doing,
        ),
        since_first_s=record.since_first_s,
        settled=settled,
    )


def _is_settled(record: TrackerRecord, left: Sequence[PlannedStop]) -> bool:
    following = left[0].group if left else None
    return following is not None and record.groups.settled_before(following)


def _remaining_s(plan: SessionPlan, record: TrackerRecord, left: Sequence[PlannedStop]) -> float | None:
    """Return how long the rest takes at the pace so far, and at least until the last stop is due."""
    each_s = record.times.mean_s(StepKind.MEASURE)
    if each_s is None:
        return None
    looks = math.ceil((len(left) + record.since_look) / plan.reference_every)
    looks_s = looks * (record.times.mean_s(StepKind.LOOK) or 0.0) if plan.measures == "points" else 0.0
    rest_s = each_s * len(left) + looks_s - record.times.in_step_s
    due = [stop.work.until_s - record.since_first_s for stop in left if stop.work is not None]
    return max([rest_s, 0.0, *due])


def present_step(
    plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord, following: PlannedStop | None
) -> Step | None:
    """Return what is due now, where `following` is the next stop that is left; None: nothing is."""
    if not record.opened:
        return plans.opening()
    if not _is_registered(record):
        if _must_warm(plan, n_fixed_nests, record):
            return plans.warming(n_fixed_nests)
        return plans.registration(plan, n_fixed_nests)
    if plan.measures == "points" and _look_is_due(plan, record, following):
        return plans.references(n_fixed_nests)
    return None if following is None else plans.visit(plan, following)


def steps(plan: SessionPlan, n_fixed_nests: int) -> Iterator[Step]:
    """Yield all steps of a session that nothing disturbs."""
    record = TrackerRecord(allowed={stop.config for stop in plan.stops})
    left = deque(plan.stops)
    while (step := present_step(plan, n_fixed_nests, record, left[0] if left else None)) is not None:
        yield step
        if step.stop is not None:
            left.popleft()
        record.end(step.kind)
        record.warm_enough |= step.kind is StepKind.WARM


def _must_warm(plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord) -> bool:
    wanted = plan.warm_up and plan.measures == "points" and not record.warm_enough
    return wanted and not warmth(record.warming, plan, n_fixed_nests).ready


def _look_is_due(plan: SessionPlan, record: TrackerRecord, following: PlannedStop | None) -> bool:
    """Whether fixed nests are looked at now: first, last, every so often, and before somebody is asked."""
    if not record.looked:
        return True
    if record.since_look == 0:
        return False
    asks = following is None or following.config not in record.allowed
    return asks or record.since_look >= plan.reference_every


def _is_registered(record: TrackerRecord) -> bool:
    """Whether the registration holds, and is of the tracker that the session measures with."""
    found = record.registration
    return record.registered and (found is None or _vouches_for(record.known("tracker"), found))


def _vouches_for(tracker: KnownDevice, registration: Registration) -> bool:
    if tracker.foreign is not None:
        return False
    if registration.instrument_serial and tracker.serial:
        return same_number(registration.instrument_serial, tracker.serial)
    return not tracker.by_person
