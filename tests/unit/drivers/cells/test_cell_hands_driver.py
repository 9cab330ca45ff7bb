"""The simulated hands' conversation, against a scripted far end."""

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.cell_hands.driver import CellHands
from truepose_drivers.cell_hands.protocol import Done, encode
from truepose_drivers.errors import RemoteProtocolError

pytestmark = pytest.mark.simulated_time


async def test_an_answer_too_many_is_not_the_answer_to_the_next_deed():
    async def serve(end: MemoryEnd) -> None:
        await end.receive()
        end.write(encode(Done("a person")))
        while await end.receive():
            end.write(encode(Done()))
            end.write(encode(Done()))

    hands = CellHands(MemoryLink(serve))
    await hands.connect()

    with pytest.raises(RemoteProtocolError, match="more than was asked"):
        await hands.do("connect", {"base": 1, "tool": 1})

    assert not hands.connected
