"""A simulated cell in this process, with an onlooker who sees every motion and where the ballbar is.

The service reaches it over TCP like any cell; the onlooker looks at what is true, not at what is said.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.journal import RememberedCell
from truepose_simulators.cell.robot import JointMotion, SpeedLimits
from truepose_simulators.instruments.cell_endpoints import clock_endpoint, hands_endpoint
from truepose_simulators.instruments.endpoint import Address, Endpoint
from truepose_simulators.instruments.gauges.ballbar import OnCalibrator, Seat, Span
from truepose_simulators.instruments.gauges.ballbar_hid import HidBallbarGadget
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.nd28x import nd28x_endpoint
from truepose_simulators.instruments.gauges.usbip import usbip_endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram, robot_endpoint
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.file import load_scenario

OnMotion: TypeAlias = Callable[[Sequence[FloatArray], SpeedLimits], None]


class OnlookedCell(RememberedCell):
    """A cell that tells of every motion before it begins, and remembers where the ballbar was when."""

    def __init__(self, scenario: str, seed: int) -> None:
        super().__init__(load_scenario(scenario), seed, CellClock(0))
        self.on_motion: OnMotion = lambda waypoints, limits: None
        self._seats: list[tuple[float, str]] = []

    def set_off(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray
    ) -> JointMotion:
        """Tell the onlooker, then move."""
        self.on_motion(waypoints_rad, limits)
        return super().set_off(waypoints_rad, limits, tool_mm)

    def do(self, action: str, details: Mapping[str, str | int | float | bool]) -> None:
        """Have the hands do one thing, and remember where the ballbar is then."""
        super().do(action, details)
        self.note_seat()

    def note_seat(self) -> None:
        """Remember where the ballbar is now."""
        self._seats.append((self.clock.now_s, self.seat))

    def seat_at(self, time_s: float) -> str:
        """Return what the ballbar was on at a cell time, as `words` has it."""
        return next((seat for since_s, seat in reversed(self._seats) if since_s <= time_s), "")

    @property
    def seat(self) -> str:
        """What the ballbar is on now."""
        return words(self.ballbar.seat(self.clock.now_s))


def words(seat: Seat | None) -> str:
    """Return a seat as "B1-T2", "T1-T3", "calibrator", or nothing for a ballbar that lies aside."""
    if isinstance(seat, OnCalibrator):
        return "calibrator"
    return f"{seat.first}-{seat.second}" if isinstance(seat, Span) else ""


@contextlib.asynccontextmanager
async def standing(
    scenario: str, seed: int, state: Path
) -> AsyncIterator[tuple[OnlookedCell, list[Address]]]:
    """Open a cell that stands where its state file left it, and close its endpoints with the context."""
    cell = OnlookedCell(scenario, seed)
    await cell.remember(state)
    cell.note_seat()
    endpoints = _endpoints(cell, tells_serial=seed % 2 == 1)
    try:
        yield cell, [await endpoint.open("127.0.0.1", 0) for endpoint in endpoints]
    finally:
        await asyncio.gather(*(endpoint.close() for endpoint in endpoints))


def _endpoints(cell: OnlookedCell, *, tells_serial: bool) -> list[Endpoint]:
    bar = Electronics(cell.ballbar, cell.faults, cell.clock)
    return [
        robot_endpoint(cell, MotionProgram(cell)),
        clock_endpoint(cell.clock),
        usbip_endpoint("hid", HidBallbarGadget(bar)) if tells_serial else nd28x_endpoint(bar),
        hands_endpoint(cell),
    ]
