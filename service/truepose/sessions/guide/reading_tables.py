"""What a session has read so far, in tables: a pure function of its plan and its ledger."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.contacts import ContactPlan
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import (
    FixedNestTaken,
    PointTaken,
    Registration,
    SessionPlan,
    Vector,
    config_of,
)
from truepose.messages.message import Text
from truepose.sessions.engine.nominal_arm import as_vector, nest_centre, nominal_chain
from truepose.sessions.guide.guide import Fixed
from truepose.sessions.tracker.registration import to_world
from truepose.sessions.tracker.state import TrackerRecord
from truepose.sessions.tracker.steps import StepKind
from truepose.sessions.tracker.tracker_measurement import scatter_limit_mm
from truepose.sessions.tracker.warm_up import Warmth, warmth

Status: TypeAlias = Literal["open", "measured", "failed", "left_out"]
_DIGITS: Final = 6  # of millimetres: nanometres


@dataclass(frozen=True, slots=True)
class NestRow:
    """A fixed nest: where its certificate has it, and where it was read at the registration."""

    number: int
    expected_mm: Vector  # in the world
    readings: int  # since the registration began that counts, or is under way
    delta_mm: Vector | None  # read minus expected, in the world; None before the tracker is placed
    scatter_mm: float | None  # of one reading, root mean square over the axes; None of fewer than two


@dataclass(frozen=True, slots=True)
class Look:
    """The fixed nests looked at once more: what they moved since the registration."""

    time_s: float
    moved_mm: tuple[float, ...]  # of each nest, in the order of the cell file
    limit_mm: float

    @property
    def worst_mm(self) -> float:
        """Of the nest that moved most."""
        return max(self.moved_mm)

    @property
    def holds(self) -> bool:
        """Whether nothing moved further than is allowed."""
        return self.worst_mm <= self.limit_mm


@dataclass(frozen=True, slots=True)
class PointRow:
    """A configuration of the plan and what came of it."""

    config: int
    nest: int
    status: Status
    expected_mm: Vector | None  # by the nominal robot, in the world; None where gauges are read
    actual_mm: Vector | None = None
    rms_mm: float | None = None
    rms_limit_mm: float | None = None  # knows the instrument
    readings: int = 0  # readings that were taken, superseded ones included
    reading_mm: tuple[float, ...] = ()  # of gauges
    reason: Text = ""  # why there is none that counts

    @property
    def delta_mm(self) -> Vector | None:
        """Actual minus expected."""
        if self.actual_mm is None or self.expected_mm is None:
            return None
        return _vector(np.subtract(self.actual_mm, self.expected_mm))

    @property
    def distance_mm(self) -> float | None:
        """From where it is expected."""
        delta = self.delta_mm
        return None if delta is None else math.hypot(*delta)


@dataclass(frozen=True, slots=True)
class Sheet:
    """Everything that was read."""

    warmth: Warmth | None  # None: the plan asks for no warm-up
    nests: tuple[NestRow, ...]
    registration: Registration | None
    looks: tuple[Look, ...]
    points: tuple[PointRow, ...]


def sheet_of(fixed: Fixed, entries: Sequence[LedgerEntry]) -> Sheet:
    """Return the tables of a session after these lines of its ledger."""
    if isinstance(fixed.plan, ContactPlan):
        return Sheet(None, (), None, (), _contact_rows(fixed.plan, entries))
    record = TrackerRecord.of(entries)
    nests = len(fixed.setup.cell.fixed_nests)
    return Sheet(
        warmth=warmth(record.warming, fixed.plan, nests) if fixed.plan.warm_up and nests else None,
        nests=_nest_rows(fixed, record, entries) if fixed.kind == "tracker" else (),
        registration=record.registration,
        looks=_looks(fixed, fixed.plan, entries),
        points=_point_rows(fixed, fixed.plan, record, entries),
    )


def _nest_rows(fixed: Fixed, record: TrackerRecord, entries: Sequence[LedgerEntry]) -> tuple[NestRow, ...]:
    taken = _of_newest_registration(entries)
    # One that was given up is still known, but no readings are compared with it.
    registration = record.registration if record.registered else None
    return tuple(
        _nest_row(number, nest.centre_mm, [one for one in taken if one.fixed_nest == number], registration)
        for number, nest in enumerate(fixed.setup.cell.fixed_nests, 1)
    )


def _of_newest_registration(entries: Sequence[LedgerEntry]) -> list[FixedNestTaken]:
    # From the beginning of the newest attempt: a step that was interrupted began again with its first
    # reading.
    begun = [i for i, one in enumerate(entries) if _begins(one, StepKind.REGISTER)]
    since = entries[begun[-1] :] if begun else ()
    return [one.fixed_nest for one in since if one.fixed_nest and one.fixed_nest.phase == "registration"]


def _begins(entry: LedgerEntry, kind: StepKind) -> bool:
    return entry.kind is EntryKind.BEGUN and entry.step_id == kind


def _nest_row(
    number: int, expected: Vector, taken: Sequence[FixedNestTaken], registration: Registration | None
) -> NestRow:
    if not taken:
        return NestRow(number, expected, 0, None, None)
    places = np.array([one.position_tracker_mm for one in taken])
    scatter = float(np.sqrt(np.mean(np.var(places, axis=0, ddof=1)))) if len(taken) > 1 else None
    delta = None if registration is None else to_world(registration, places.mean(axis=0)) - expected
    return NestRow(number, expected, len(taken), None if delta is None else _vector(delta), scatter)


def _looks(fixed: Fixed, plan: SessionPlan, entries: Sequence[LedgerEntry]) -> tuple[Look, ...]:
    """Return the looks in which every nest was read; where one is read again in it, that counts."""
    certified = [nest.centre_mm for nest in fixed.setup.cell.fixed_nests]
    found: list[Look] = []
    moved: dict[int, float] = {}
    for entry in entries:
        if _begins(entry, StepKind.LOOK):
            moved = {}
        taken = entry.fixed_nest
        if taken is None or taken.phase != "reference" or taken.position_world_mm is None:
            continue
        moved[taken.fixed_nest] = math.dist(taken.position_world_mm, certified[taken.fixed_nest - 1])
        # A look that was broken off says nothing of the nests it did not come to.
        if len(moved) == len(certified):
            ways = tuple(moved[number] for number in sorted(moved))
            found.append(Look(entry.time_s, ways, plan.reference_limit_mm))
            moved = {}
    return tuple(found)


def _point_rows(
    fixed: Fixed, plan: SessionPlan, record: TrackerRecord, entries: Sequence[LedgerEntry]
) -> tuple[PointRow, ...]:
    taken = _points_by_config(entries)
    reasons = _reasons(entries)
    expected = _expected(fixed, plan)
    rows = []
    for stop, place in zip(plan.stops, expected, strict=True):
        of_stop = taken.get(stop.config, [])
        status = _status(stop.config, record)
        counts = of_stop[-1] if of_stop and status == "measured" else None
        rows.append(
            PointRow(
                config=stop.config,
                nest=stop.nest,
                status=status,
                expected_mm=_vector(place),
                actual_mm=None if counts is None else counts.position_world_mm,
                rms_mm=None if counts is None else counts.rms_mm,
                rms_limit_mm=None if counts is None else scatter_limit_mm(plan, counts.covariance_mm2),
                readings=len(of_stop),
                reason=reasons.get(stop.config, "") if status in {"failed", "left_out"} else "",
            )
        )
    return tuple(rows)


def _points_by_config(entries: Sequence[LedgerEntry]) -> dict[int, list[PointTaken]]:
    found: dict[int, list[PointTaken]] = {}
    for entry in entries:
        if entry.point is not None:
            found.setdefault(entry.point.config, []).append(entry.point)
    return found


def _reasons(entries: Sequence[LedgerEntry]) -> dict[int, Text]:
    skipped = (entry for entry in entries if entry.kind is EntryKind.SKIPPED)
    named = ((config_of(entry.step_id), entry.text) for entry in skipped)
    return {config: text for config, text in named if config is not None}


def _status(config: int, record: TrackerRecord) -> Status:
    # First what a person decided, then what came of it: a configuration that is left out may have been
    # measured.
    if config in record.left_out:
        return "left_out"
    if config in record.measured:
        return "measured"
    return "failed" if config in record.skipped else "open"


def _expected(fixed: Fixed, plan: SessionPlan) -> FloatArray:
    """Return where the nominal robot has the nest of each stop [mm, world], shape (n, 3)."""
    cell = fixed.setup.cell
    chain = nominal_chain(cell.robot, cell.base_nominal, np.array([stop.joints_rad for stop in plan.stops]))
    found = np.zeros((len(plan.stops), 3))
    for nest in {stop.nest for stop in plan.stops}:
        rows = [i for i, stop in enumerate(plan.stops) if stop.nest == nest]
        found[rows] = chain.points(nest_centre(cell.nests, nest))[rows]
    return found


def _contact_rows(plan: ContactPlan, entries: Sequence[LedgerEntry]) -> tuple[PointRow, ...]:
    read = {entry.contact.config: entry.contact for entry in entries if entry.contact is not None}
    reasons = _reasons(entries)
    rows = []
    for stop in plan.stops:
        taken, reason = read.get(stop.config), reasons.get(stop.config)
        status: Status = "measured" if taken else "open" if reason is None else "failed"
        values = () if taken is None else taken.reading_mm
        rows.append(
            PointRow(
                stop.config, plan.nest, status, None, readings=len(values) > 0, reading_mm=values,
                reason="" if taken else reason or "",
            )
        )  # fmt: skip
    return tuple(rows)


def _vector(point: FloatArray) -> Vector:
    return as_vector(point, _DIGITS)
