"""Before a session without the ballbar moves the arm the bar is asked whether it hangs in the cell."""

import math

import pytest

from tests.helpers.ballbar.cells import domain_cell
from truepose.domain.cell import BallbarKit, DeviceEntry
from truepose.domain.ledger import BALLBAR_ON, EntryKind, LedgerEntry
from truepose.sessions.ballbar.removal_check import BarPutAway
from truepose.sessions.devices import DeviceRegistry, MountedDevice
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import NotNowError
from truepose.storage.records import LedgerRecord, SessionSetup
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
    return DeviceRegistry([mounted], clock), bar


class Records:
    """Of a cell whose last session with the ballbar ended with it put away, as far as they tell."""

    def __init__(self):
        self.lines = []

    async def setup(self, session_id):
        return SessionSetup(domain_cell(ballbar=BallbarKit()))

    async def with_ballbar(self, *, simulated):
        return []

    async def newest_at(self, *steps, simulated):
        return LedgerRecord(len(self.lines), "", self.lines[-1]) if self.lines else None

    async def note(self, session_id, step_id, text):
        self.lines.append(LedgerEntry(step_id, EntryKind.NOTED, 0.0, text=text))


CONFIRM = OperatorCommand(CommandName.CONFIRM, "Ada")


async def judged(rack, records=None):
    records = records or Records()
    return await BarPutAway(records, records, rack, records.note).judged(1, CONFIRM)


async def test_a_ballbar_that_reads_a_length_keeps_the_arm_where_it_is():
    rack, bar = rack_with()

    records = Records()

    with pytest.raises(NotNowError, match="from the last session"):
        await judged(rack, records)

    assert [line.step_id for line in records.lines] == [BALLBAR_ON]  # from now on it counts as attached

    assert not bar.connected  # its link is left as it was


@pytest.mark.parametrize(
    ("shown_mm", "signal"), [(math.nan, "none"), (1.05, "out_of_range"), (-17.2, "good")]
)
async def test_one_that_lies_aside_keeps_nothing(shown_mm, signal):
    rack, bar = rack_with(shown_mm, signal)

    await judged(rack)

    assert not bar.connected


async def test_one_that_cannot_be_read_says_nothing():
    rack, bar = rack_with()
    bar.connect_fails = ConnectFailedError("no ballbar at this port")
    await judged(rack)
    bar.connect_fails, bar.read_fails = None, NoReplyError("nothing came")

    await judged(rack)

    assert not bar.connected


async def test_a_link_that_was_open_stays_open():
    rack, bar = rack_with(math.nan, "none")
    await bar.connect()

    await judged(rack)

    assert bar.connected


async def test_a_cell_without_a_ballbar_asks_nobody():
    assert await judged(DeviceRegistry([], Clock())) is CONFIRM
