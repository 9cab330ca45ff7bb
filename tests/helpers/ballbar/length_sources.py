"""Hand-written stand-ins for the bar and the hands of a simulated cell."""

import math

from truepose_simulators.errors import SimulatorError
from truepose_simulators.faults.scripted import Faults
from truepose_simulators.instruments.gauges.length_source import Electronics, Sample


class FakeBar:
    """Shows what the test sets; counts how often it was asked."""

    def __init__(self) -> None:
        self.plugged = True
        self.deviation_mm = 0.1234
        self.signal = "good"
        self.temperature_c = 21.37
        self.asked = 0

    def sample(self, time_s: float) -> Sample:
        self.asked += 1
        deviation_mm = math.nan if self.signal == "none" else self.deviation_mm
        return Sample(deviation_mm, self.signal, self.asked, self.temperature_c)


class FakeHands:
    """Does whatever is asked and keeps it, but refuses to juggle."""

    def __init__(self) -> None:
        self.deeds: list[tuple[str, dict]] = []

    def do(self, action: str, details) -> None:
        if action == "juggle":
            raise SimulatorError("two balls are not enough to juggle")
        self.deeds.append((action, dict(details)))


class StandingClock:
    """Cell time that the test moves."""

    now_s = 0.0


def electronics(bar: FakeBar, faults: Faults | None = None) -> Electronics:
    """The bar's electronics at cell time 0."""
    return Electronics(bar, faults or Faults(), StandingClock())
