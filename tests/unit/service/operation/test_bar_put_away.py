"""Before a session without the ballbar moves the arm the bar is asked whether it hangs in the cell."""

import math

import pytest

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.cell.description import DeviceEntry
from truepose.operation.ballbar.bar_put_away import require_ballbar_aside
from truepose.operation.devices import MountedDevice, Rack
from truepose.sequencing.errors import NotNowError
from truepose_drivers.api import BallbarReading
from truepose_drivers.errors import ConnectFailedError, NoReplyError


class Clock:
    time_s = 100.0

    async def now_s(self):
        return self.time_s

    async def sleep(self, duration_s):
        self.time_s += duration_s


class Bar:
    """Shows the same sample again and again."""

    def __init__(self, clock, deviation_mm, signal):
        self._clock, self._shown = clock, (deviation_mm, signal)
        self.connected = False
        self.connect_fails = self.read_fails = None

    async def connect(self):
        if self.connect_fails:
            raise self.connect_fails
        self.connected = True

    async def close(self):
        self.connected = False

    async def read(self):
        if self.read_fails:
            raise self.read_fails
        return BallbarReading(*self._shown, 1e-4, self._clock.time_s)


def rack_with(deviation_mm=0.3, signal="good"):
    clock = Clock()
    bar = Bar(clock, deviation_mm, signal)
    mounted = MountedDevice(DeviceEntry("ballbar", "fake", {}), "ballbar", "fake", bar)
    return Rack([mounted], clock), bar


async def test_a_ballbar_that_reads_a_length_keeps_the_arm_where_it_is():
    rack, bar = rack_with()

    with pytest.raises(NotNowError, match="since the last session"):
        await require_ballbar_aside(rack, BallbarKit())

    assert not bar.connected  # its link is left as it was


@pytest.mark.parametrize(
    ("shown_mm", "signal"), [(math.nan, "none"), (1.05, "out_of_range"), (-17.2, "good")]
)
async def test_one_that_lies_aside_keeps_nothing(shown_mm, signal):
    rack, bar = rack_with(shown_mm, signal)

    await require_ballbar_aside(rack, BallbarKit())

    assert not bar.connected


async def test_one_that_cannot_be_read_says_nothing():
    rack, bar = rack_with()
    bar.connect_fails = ConnectFailedError("no ballbar at this port")
    await require_ballbar_aside(rack, BallbarKit())
    bar.connect_fails, bar.read_fails = None, NoReplyError("nothing came")

    await require_ballbar_aside(rack, BallbarKit())

    assert not bar.connected


async def test_a_link_that_was_open_stays_open():
    rack, bar = rack_with(math.nan, "none")
    await bar.connect()

    await require_ballbar_aside(rack, None)

    assert bar.connected


async def test_a_cell_without_a_ballbar_asks_nobody():
    await require_ballbar_aside(Rack([], Clock()), None)
