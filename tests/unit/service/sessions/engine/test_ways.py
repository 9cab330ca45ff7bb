"""The arm goes straight ways that were looked at, and others only after a look or a word of a person."""

import math

import numpy as np
import pytest

from truepose.messages.message import message, together
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.engine.ways import KnownWays, rest_of_way
from truepose.sessions.errors import WayNotClearError

A, B, C, D = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)
TOUCHES = message("room.be_ready")
NAME = message("room.end.here")


class Eyes:
    """Looks at ways; something touches on all that lead to `blocked`."""

    def __init__(self, blocked=()):
        self.blocked = blocked
        self.seen = []

    async def look(self, ways):
        found = [*zip(map(tuple, ways.start_rad.tolist()), map(tuple, ways.end_rad.tolist()), strict=True)]
        self.seen += found
        return TOUCHES if any(end in self.blocked for _, end in found) else ""


def ways_of(*places):
    return Ways((), np.array(places[:-1]), np.array(places[1:]))


@pytest.mark.parametrize(
    ("start", "end", "is_known"),
    [
        (A, B, True),
        (B, A, True),  # room is the same in both directions
        ((0.2, 0.0), (0.7, 0.0), True),  # a piece of it
        ((0.2, 0.005), B, True),  # a reported angle is rounded
        ((0.2, 0.02), B, False),
        (A, C, False),  # past the place between
        ((0.5, 0.0), (1.0, 0.5), False),  # from one known way to another
        (D, (0.0, 1.005), True),  # no motion at all
    ],
)
async def test_a_way_is_known_where_it_lies_on_one_that_was_looked_at(start, end, is_known):
    eyes = Eyes()
    ways = KnownWays(eyes.look)
    await ways.require_planned((A, B, C), NAME)

    assert await ways.require(start, end, 0.01) is not is_known
    assert eyes.seen == [(A, B), (B, C)] + ([] if is_known else [(start, end)])


async def test_a_clear_way_is_looked_at_once():
    eyes = Eyes()
    ways = KnownWays(eyes.look)

    assert [await ways.require(A, B, 0.01) for _ in range(2)] == [True, False]
    assert eyes.seen == [(A, B)]


async def test_planned_ways_are_looked_at_once_and_refused_where_something_touches():
    eyes = Eyes(blocked=(C,))
    ways = KnownWays(eyes.look)
    await ways.require_planned((A, B), NAME)
    with pytest.raises(WayNotClearError) as refused:
        await ways.require_planned((A, B, C), NAME)

    ways.confirm(refused.value.text)
    await ways.require_planned((A, B, C), NAME)

    assert eyes.seen == [(A, B), (B, C)]


async def test_ways_that_were_looked_at_ahead_are_known():
    eyes = Eyes()
    ways = KnownWays(eyes.look)

    assert await ways.what_to_watch(ways_of(A, B, C)) == ""
    assert await ways.require(A, B, 0.01) is False
    assert len(eyes.seen) == 2


async def test_a_way_on_which_something_touches_is_gone_once_the_person_was_told_who_confirms():
    ways = KnownWays(Eyes(blocked=(C,)).look)
    with pytest.raises(WayNotClearError) as refused:
        await ways.require(A, C, 0.01)

    ways.confirm(together(refused.value.text, CELL_CLEAR))

    assert await ways.require(A, C, 0.01) is False
    with pytest.raises(WayNotClearError):
        await ways.require(D, C, 0.01)  # from elsewhere it is another way


@pytest.mark.parametrize("ahead", [True, False])
async def test_a_question_that_says_nothing_of_a_way_lets_the_arm_go_none(ahead):
    ways = KnownWays(Eyes(blocked=(C,)).look)
    if ahead:
        assert await ways.what_to_watch(ways_of(A, C)) == TOUCHES
    else:
        with pytest.raises(WayNotClearError):
            await ways.require(A, C, 0.01)

    ways.confirm(CELL_CLEAR)

    with pytest.raises(WayNotClearError):
        await ways.require(A, C, 0.01)


WAY = ((0.0, 0.0), (1.0, 0.0), (1.0, 2.0))


@pytest.mark.parametrize(
    ("here", "left"),
    [
        ((-0.5, 0.0), WAY),  # before its first point: from the stop before
        ((0.0, 0.0), WAY[1:]),
        ((0.4, 0.0), WAY[1:]),  # halted between two points
        ((1.0, 0.0), WAY[2:]),
        ((1.0, 1.9), WAY[2:]),
        ((1.0, 2.0), WAY[2:]),  # at its end: that is gone to in any case
        ((0.5, 0.5), WAY),  # beside it
        ((0.0, 0.0, 0.0), WAY),  # another arm
        ((math.nan, 0.0), WAY),
    ],
)
def test_an_arm_that_was_halted_on_its_way_goes_on_along_it(here, left):
    assert rest_of_way(WAY, here, 1e-3) == left
