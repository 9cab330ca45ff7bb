"""Dull sessions and readings."""

from truepose.domain.cell import Cell, DeviceEntry
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import FixedNest, JointRow, Nest, Robot
from truepose.domain.session import FixedNestTaken, PlannedStop, PointTaken, SessionPlan, stop_id
from truepose.storage.records import SessionSetup


def make_setup():
    row = JointRow(0.0, 0.0, 0.0, 0.0)
    return SessionSetup(
        Cell(
            name="bench",
            robot_key="arm",
            robot=Robot("arm", (row,) * 2),
            nests=(Nest((0.0, 0.0, 100.0), 0.002),),
            fixed_nests=(FixedNest((600.0, 0.0, 0.0), 0.002),),
            devices=(DeviceEntry("tracker", "leica_emscon", {"host": "127.0.0.1", "port": 700}),),
        )
    )


def make_plan(n=2, role="calibration"):
    return SessionPlan(role, tuple(PlannedStop(k, (0.1 * k, 0.0), 1) for k in range(1, n + 1)))


def make_point(config=1, x_mm=1.0, nest=1):
    return PointTaken(
        config=config,
        nest=nest,
        commanded_rad=(0.1, 0.0),
        reported_rad=(0.1, 0.0),
        direction=(1, 1),
        time_s=10.0 * config,
        temperature_c=23.0,
        attachment=1,
        position_tracker_mm=(x_mm, 2.0, 3.0),
        position_world_mm=(x_mm + 100, 2.0, 3.0),
        standard_uncertainty_mm=0.015,
        rms_mm=0.01,
        samples=100,
    )


def make_fixed_nest(time_s=5.0, phase="reference"):
    return FixedNestTaken(phase, 1, 1, time_s, (0.0, 0.0, 0.0), (600.0, 0.0, 0.0), 0.01)


def point_taken(point):
    return LedgerEntry(stop_id(point.config), EntryKind.MEASURED, point.time_s, point=point)


def fixed_nest_taken(reading):
    return LedgerEntry("fixed-nests", EntryKind.READ, reading.time_s, fixed_nest=reading)


def entered(state, text, person=None, time_s=0.0):
    return LedgerEntry("", EntryKind.CONTROL, time_s, person, text=text, entered=state)
