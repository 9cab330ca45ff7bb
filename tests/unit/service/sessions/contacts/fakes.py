"""A robot that errs by some millimetres, and gauges that touch what stands in the world."""

import math

import numpy as np

from tests.unit.service.sessions.stand_ins import Device, nothing_in_the_way
from tests.unit.service.sessions.tracker.fakes import IRB120, NESTS, FakeClock, FakeRobot, ListLedger
from truepose.domain.cell import Cell
from truepose.domain.contacts import ContactPlan, Target, TargetKind
from truepose.domain.robot import FramePlacement
from truepose.planning.contacts.plan import plan_of
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.sessions.contact.measuring import ContactCell, GaugeBox
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose_drivers.api import BallbarReading
from truepose_drivers.errors import ConnectionLostError

RADII_MM = 16.0
TRAVEL_MM = 5.5
CELL = Cell("test", "abb-irb-120", IRB120, nests=NESTS)
SPHERE = Target(1, TargetKind.SPHERE, zero_mm=RADII_MM, place_mm=(400.0, 0.0, 150.0))


def planned(stops: int = 6, **changes) -> ContactPlan:
    return plan_of(CELL, ContactPlanRequest("probe", (SPHERE,), stops, nest=2, **changes))


class FakeProbe(Device):
    """A gauge in the tool that touches the sphere, which stands beside its place."""

    def __init__(self, clock: FakeClock, robot: FakeRobot) -> None:
        super().__init__("Acme", "probe", "unknown", "1")
        self._clock = clock
        self._robot = robot
        self.centre_mm = np.add(SPHERE.place_mm, (0.8, -0.6, 0.5))
        self.sign = 1.0
        self.signal = "good"
        self.lost_after: int | None = None  # readings
        self.readings = 0
        self.deepest_mm = -math.inf

    async def read(self) -> BallbarReading:
        self.readings += 1
        if self.readings == self.lost_after or not self.connected:
            self.connected = False
            raise ConnectionLostError("the gauge's cable is out")
        pushed_mm = self._pushed_mm()
        self.deepest_mm = max(self.deepest_mm, pushed_mm)
        free = abs(pushed_mm) > TRAVEL_MM
        shown_mm = math.copysign(TRAVEL_MM, pushed_mm) if free else pushed_mm
        signal = "out_of_range" if free and self.signal == "good" else self.signal
        return BallbarReading(self.sign * shown_mm, signal, 1e-4, self._clock.time_s)

    async def read_channels(self) -> tuple[BallbarReading, ...]:
        return (await self.read(),)

    def _pushed_mm(self) -> float:
        chain = nominal_chain(IRB120, FramePlacement(), np.array([self._robot.joints]))
        tip_mm, axis = chain.points(np.array(NESTS[1].centre_mm))[0], chain.end_rotation[0][:, 2]
        off = tip_mm - self.centre_mm
        along = float(axis @ off)
        inside = along**2 - float(off @ off) + RADII_MM**2
        return along + math.sqrt(inside) if inside >= 0.0 else -math.inf


class Bench:
    """Clock, robot, probe and ledger of one cell."""

    def __init__(self) -> None:
        self.clock = FakeClock()
        self.robot = FakeRobot(self.clock)
        self.probe = FakeProbe(self.clock, self.robot)
        self.journal = ListLedger()

    def cell(self, **changes) -> ContactCell:
        known = {
            "gauges": (GaugeBox("probe", self.probe, changes.pop("gauge_serial", "")),),
            "robot_controller": self.robot,
            "clock": self.clock,
            "robot": IRB120,
            "look_at_ways": nothing_in_the_way,
        }
        return ContactCell(**known | changes)

    @property
    def read(self):
        return [entry.contact for entry in self.journal.entries if entry.contact is not None]
