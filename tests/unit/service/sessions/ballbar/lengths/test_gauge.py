"""A ballbar's link that is lost is found again, without hurry and without end."""

import pytest

from tests.unit.service.sessions.ballbar.fakes import Bar, Clock, Hands, Robot
from truepose.sessions.ballbar.live import Gauge
from truepose_drivers.api import DeviceIdentity
from truepose_drivers.errors import ConnectionLostError, DriverFaultError, NoReplyError


class CountedBar(Bar):
    attempts = 0

    async def connect(self) -> None:
        self.attempts += 1
        await super().connect()


def make_gauge():
    clock = Clock()
    hands = Hands(Robot(clock))
    hands.connect("calibrator")
    bar = CountedBar(clock, hands)
    return clock, bar, Gauge(bar, clock)


async def test_attempts_grow_rarer_but_never_end():
    clock, bar, gauge = make_gauge()
    bar.plugged = False

    for _ in range(20 * 60):
        assert await gauge.read() is None
        clock.time_s += 0.05

    # waits of 0.25, 0.5, 1, 2, and 4 s from then on: 4 + 56/4 attempts in a minute, and the first
    assert 18 <= bar.attempts <= 20
    assert "check the cable" in gauge.trouble


async def test_a_cable_that_is_back_is_noticed_within_the_longest_wait():
    clock, bar, gauge = make_gauge()
    bar.plugged = False
    for _ in range(20 * 60):
        await gauge.read()
        clock.time_s += 0.05

    bar.plugged = True
    clock.time_s += 4.0

    assert await gauge.read() is not None
    assert gauge.trouble is None


async def test_a_clock_that_begins_anew_does_not_make_it_wait_for_ever():
    clock, bar, gauge = make_gauge()
    bar.plugged = False
    await gauge.read()

    clock.time_s = 0.0
    bar.plugged = True

    assert await gauge.read() is not None


@pytest.mark.parametrize(
    ("fault", "lost"), [(ConnectionLostError, True), (DriverFaultError, True), (NoReplyError, False)]
)
async def test_only_a_gauge_that_vanishes_has_lost_its_supply(fault, lost):
    _, bar, gauge = make_gauge()
    await gauge.read()
    bar.lost, bar.plugged = fault, False

    await gauge.read()

    assert gauge.lost_power is lost


async def test_a_serial_number_that_the_device_does_not_know_is_none():
    _, bar, gauge = make_gauge()

    async def identify():
        return DeviceIdentity("HEIDENHAIN", "ND 287", "unknown", "1")

    bar.identify = identify

    await gauge.read()

    assert gauge.serial == ""
