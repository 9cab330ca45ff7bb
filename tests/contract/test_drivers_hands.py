"""What the simulated hands promise."""

import pytest

from truepose_drivers.errors import DeviceRefusedError


@pytest.fixture
async def hands(bench):
    hands = bench.driver("cell_hands")
    await hands.connect()
    return hands


async def test_a_deed_is_done_before_the_answer_comes(bench, hands):
    await hands.do("connect", {"base": 2, "tool": 3})
    await hands.do("place_base", {"placement": 1, "x_mm": 300.5, "rz_deg": -15})

    assert bench.hands.deeds == [
        ("connect", {"base": 2, "tool": 3}),
        ("place_base", {"placement": 1, "x_mm": 300.5, "rz_deg": -15}),
    ]


async def test_a_deed_that_is_refused_says_why_and_the_next_is_done(bench, hands):
    with pytest.raises(DeviceRefusedError, match="not enough to juggle"):
        await hands.do("juggle", {})
    await hands.do("detach", {})

    assert bench.hands.deeds == [("detach", {})]


@pytest.mark.parametrize("details", [{"x_mm": float("nan")}, {"op": "who"}, {"action": "detach"}])
async def test_a_detail_that_cannot_be_sent_is_refused_here(bench, hands, details):
    with pytest.raises(DeviceRefusedError):
        await hands.do("place_base", details)

    assert bench.hands.deeds == []
