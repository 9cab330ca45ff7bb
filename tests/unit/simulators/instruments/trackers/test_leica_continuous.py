"""Continuous measurement by time behind the simulated emScon server, in bytes packed by hand."""

import struct

import pytest

from tests.unit.simulators.instruments.trackers.emscon_server import (
    NO_DISTANCE,
    OK,
    Server,
    answer,
    error,
    event,
)
from truepose_simulators.instruments.accuracy import ProbeSetup
from truepose_simulators.instruments.tracker import in_tracker_frame

CONTINUOUS_TIME = 1
REACHED = 28
WRONG_PARAMETER_1, WRONG_PARAMETER_2, WRONG_PARAMETER_3 = 4, 5, 6


async def server_with(make_cell, separation_ms=100, points=7, extended=0) -> Server:
    server = Server(make_cell("irb120-probe", probe=ProbeSetup()))
    await server.start()
    await server.ask(24, struct.pack("<i", CONTINUOUS_TIME))
    await server.ask(30, struct.pack("<4i", separation_ms, points, 0, 0))
    await server.ask(80, struct.pack("<2i", 0, extended))
    return server


def members(packet):
    """Status, count, mode and try mode; the air; then the bytes of the elements."""
    return struct.unpack_from("<I3i", packet, 8), struct.unpack_from("<3d", packet, 24), packet[48:]


async def test_values_come_in_blocks_until_their_number_is_reached(make_cell):
    server = await server_with(make_cell)
    await server.go_to_fixed_nest(1)
    true = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[0])

    accepted, *blocks = await server.ask(49)

    assert accepted == answer(49)
    # Three packets a second: 3 values of 0.1 s each; the last holds what is left of 7.
    assert [struct.unpack_from("<iI", block) for block in blocks] == [(156, 3), (156, 3), (84, 3)]
    assert [members(block)[0] for block in blocks] == [(OK, n, CONTINUOUS_TIME, 0) for n in (3, 3, 1)]
    assert members(blocks[0])[1] == pytest.approx((23.0, 1013.25, 45.0), abs=1.0)
    values = [value for block in blocks for value in struct.iter_unpack("<3i3d", members(block)[2])]
    assert [value[:3] for value in values] == [(OK, 0, 100_000 * k) for k in range(1, 8)]
    assert all(value[3:] == pytest.approx(true, abs=0.12) for value in values)
    assert len({value[3:] for value in values}) == 7


async def test_the_extended_packet_adds_what_the_accuracy_model_states(make_cell):
    server = await server_with(make_cell, points=1, extended=1)
    await server.go_to_fixed_nest(1)

    _, packet = await server.ask(49)

    assert struct.unpack_from("<iI", packet) == (140, 10)
    *_, std1, std2, std3, total, _, _, _ = struct.unpack_from("<3i10d", packet, 48)
    assert total == pytest.approx((std1**2 + std2**2 + std3**2) ** 0.5)
    assert 0.001 < total < 0.1


async def test_the_packet_rate_sets_the_length_of_a_block(make_cell):
    server = await server_with(make_cell)
    await server.go_to_fixed_nest(1)

    assert (await server.ask(120, struct.pack("<2i", 400, 0)))[0] == answer(120, WRONG_PARAMETER_2)
    await server.ask(120, struct.pack("<2i", 400, 10))

    assert len(await server.ask(49)) == 1 + 7


async def test_nothing_is_measured_without_a_reflector(make_cell):
    server = await server_with(make_cell)
    server.cell.tracker.release()

    assert await server.ask(49) == [answer(49, NO_DISTANCE)]


async def test_a_lost_reflector_ends_the_stream_with_an_error(make_cell):
    server = await server_with(make_cell, separation_ms=1000, points=0)
    await server.go_to_fixed_nest(1)
    tracker, measured = server.cell.tracker, []
    measure = tracker.measure

    def lost_after_two(duration_s):
        if len(measured) == 2:
            tracker.release()
        measured.append(duration_s)
        return measure(duration_s)

    tracker.measure = lost_after_two

    _, *blocks, last = await server.ask(49)

    assert [struct.unpack_from("<iI", block) for block in blocks] == [(84, 3), (84, 3)]
    assert last == error(49, NO_DISTANCE)


async def test_the_end_is_announced_to_whoever_wants_events(make_cell):
    server = await server_with(make_cell, points=1)
    await server.ask(47, struct.pack("<9i", 2, 0, 0, 1, 1, 0, 0, 1, 0))
    await server.go_to_fixed_nest(1)

    packets = await server.ask(49)

    assert packets[1] == event(26)
    assert packets[-2:] == [event(REACHED), event(27)]


@pytest.mark.parametrize(
    ("wanted", "status"),
    [
        ((0, 0, 0, 0), WRONG_PARAMETER_1),
        ((1, -1, 0, 0), WRONG_PARAMETER_2),
        ((1, 0, 1, 0), WRONG_PARAMETER_3),  # no region is known here
    ],
)
async def test_what_it_cannot_do_is_refused_and_the_old_settings_stay(make_cell, wanted, status):
    server = await server_with(make_cell)

    refused = await server.ask(30, struct.pack("<4i", *wanted))

    assert refused == [answer(30, status)]
    assert await server.ask(31) == [answer(31, OK, struct.pack("<4i", 100, 7, 0, 0))]
