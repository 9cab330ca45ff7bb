"""Dull ballbar sessions: a plan of a few poses and what happened in them."""

from truepose.domain.ballbar import (
    ArrivalTaken,
    BallbarPlan,
    LengthTaken,
    PlannedPlacement,
    PlannedPose,
    PlannedSetup,
)
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import FramePlacement

LEGS = ((1, 1), (1, 2), (2, 2), (2, 3), (3, 3), (3, 1))


def make_ballbar_plan(n_poses=2):
    return BallbarPlan((
        PlannedPlacement(
            number=1,
            frame=FramePlacement(400.0, 0.0, 0.0),
            cups_mm=((400.0, 0.0, 0.0), (700.0, 0.0, 0.0), (550.0, 260.0, 0.0)),
            setups=tuple(PlannedSetup(k, (0.1 * k,) * 6) for k in (1, 2, 3)),
            poses=tuple(PlannedPose(k, 1, (0.2 * k,) * 6, LEGS) for k in range(1, n_poses + 1)),
        ),
    ))


def make_length(length_mm=300.1, **changed):
    return LengthTaken(**{
        "length_mm": length_mm,
        "deviation_mm": 0.1,
        "zero_mm": 0.0,
        "standard_uncertainty_mm": 0.0017,
        "spread_mm": 0.001,
        "samples": 20,
        "initialisation": 1,
        "by_hand": False,
        "temperature_c": 23.0,
        "instrument_serial": "L20042",
        "certificate": "report 7",
        "certificate_expires": "2027-01-31",
        "time_s": 60.0,
        **changed,
    })


def measured(step_id, length_mm=300.1, **changed):
    return LedgerEntry(step_id, EntryKind.MEASURED, 60.0, length=make_length(length_mm), **changed)


def moved(step_id, commanded_rad):
    arrival = ArrivalTaken(commanded_rad, commanded_rad, (1,) * len(commanded_rad), 50.0)
    return LedgerEntry(step_id, EntryKind.MOVED, 50.0, arrival=arrival)


def skipped(step_id, reason="out of range"):
    return LedgerEntry(step_id, EntryKind.SKIPPED, 70.0, text=reason, person="Ada")
