"""The hands as an endpoint: one deed after the other, each answered."""

import json

import pytest

from tests.helpers.ballbar.length_sources import FakeHands
from truepose_simulators.instruments.cell_endpoints import hands_endpoint


class FakeStream:
    def __init__(self, *pieces: bytes) -> None:
        self._pieces = [*pieces, b""]
        self.heard = b""

    async def read(self, limit: int) -> bytes:
        return self._pieces.pop(0)

    def write(self, data: bytes) -> None:
        self.heard += data

    async def drain(self) -> None: ...


async def answers(hands, *pieces: bytes) -> list[dict]:
    stream = FakeStream(*pieces)
    await hands_endpoint(hands)._serve(stream, stream)
    return [json.loads(line) for line in stream.heard.splitlines()]


async def test_deeds_are_done_in_order_however_they_arrive():
    hands = FakeHands()

    said = await answers(
        hands,
        b'{"op": "do", "action": "connect", "base": 2, "tool": 3}\n{"op": "do", "act',
        b'ion": "detach"}\n{"op": "who"}\n',
    )

    assert said == [{"ok": True}, {"ok": True}, {"ok": True, "who": "simulated hands"}]
    assert hands.deeds == [("connect", {"base": 2, "tool": 3}), ("detach", {})]


@pytest.mark.parametrize("line", [b'{"op": "do", "action": "juggle"}\n', b"nonsense\n", b"\n", b"[]\n"])
async def test_what_cannot_be_done_is_a_sentence_and_the_next_is_done(line):
    hands = FakeHands()

    refused, done = await answers(hands, line + b'{"op": "do", "action": "detach"}\n')

    assert refused.keys() == {"error"}
    assert len(refused["error"].split()) > 2
    assert done == {"ok": True}


async def test_a_line_without_end_is_told_and_hung_up_on():
    (refused,) = await answers(FakeHands(), b"x" * 2000)

    assert "1024" in refused["error"]


async def test_hands_that_take_their_time_are_waited_for():
    class SlowHands:
        async def do(self, action, details) -> None:
            self.done = action

    hands = SlowHands()

    assert await answers(hands, b'{"op": "do", "action": "detach"}\n') == [{"ok": True}]
    assert hands.done == "detach"
