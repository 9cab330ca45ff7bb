import json

import pytest

from truepose_drivers.cell_clock.protocol import encode
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.instruments.cell_endpoints import answer_clock


async def ask(clock, line):
    return json.loads(encode(await answer_clock(line, clock)))


async def test_sleeping_lets_cell_time_go_by_for_everybody():
    clock = CellClock(0)

    after = await ask(clock, b'{"op": "sleep", "s": 4.0}')

    assert after == {"now_s": 4.0}
    assert await ask(clock, b'{"op": "now"}') == {"now_s": 4.0}
    assert clock.now_s == 4.0


@pytest.mark.parametrize("line", [b"{", b"[]", b'{"op": "stop"}', b'{"op": "sleep", "s": -1}', b"\xff\xfe"])
async def test_a_request_that_makes_no_sense_is_answered_with_a_sentence_and_moves_nothing(line):
    clock = CellClock(0)

    assert "error" in await ask(clock, line)
    assert clock.now_s == 0.0
