"""Every kind of session looks at ways by what the cell file forbids today, not as it was planned."""

from dataclasses import replace

import numpy as np
import pytest

from tests.integration.sessions.test_longest_pieces import SETUPS, cell_of, rack_of, unconnected
from tests.unit.service.planning.test_keep_outs import CONVEYOR
from tests.unit.service.sessions.ballbar.sessions import make_placement
from tests.unit.service.sessions.tracker.fakes import FakeClock
from truepose.domain.cell import CellLimits, KeepOuts
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.cell import CurrentCell

INTO_IT = Ways(
    (message("room.end.here"),), np.radians([[-10, 30, 0, 0, 0, 0]]), np.radians([[90, 30, 0, 0, 0, 0]])
)
TODAY = CellLimits(keep_outs=KeepOuts((CONVEYOR,)))


@pytest.mark.parametrize("kind", SETUPS)
async def test_a_volume_that_was_stated_after_the_planning_is_seen(kind):
    rack, planned = rack_of(unconnected("abb_open_abb"), FakeClock()), SETUPS[kind].cell
    cells = [
        cell_of(kind, rack, CurrentCell(replace(planned, limits=limits)))
        for limits in (planned.limits, TODAY)
    ]

    told = [english(await cell.look_at_ways(INTO_IT)) for cell in cells]

    assert ["keep-out volume conveyor" in one for one in told] == [False, True]


async def test_a_ballbar_s_other_ways_are_looked_at_with_the_fixture():
    cell = cell_of("ballbar", rack_of(unconnected("abb_open_abb"), FakeClock()))
    place = make_placement(1, ())
    in_reach = replace(place, cups_mm=tuple((x + 250.0, y - 100.0, 350.0) for x, y, _ in place.cups_mm))

    told = [english(await cell.look_past_fixture(one, None, INTO_IT)) for one in (place, in_reach)]

    assert ["base fixture" in one for one in told] == [False, True]
