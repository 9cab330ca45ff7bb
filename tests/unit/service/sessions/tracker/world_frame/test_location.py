"""Finding the fixed nests when nothing but roughly the tracker's place is known, or not even that."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.sessions.tracker.fakes import FIXED_NESTS, TRACKER_AT, FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.session import SessionState
from truepose.sessions.errors import ReadingRejectedError
from truepose.sessions.tracker.reference_nests import AIMED_RADIUS_MM, locate_tracker
from truepose.sessions.tracker.registration import to_tracker
from truepose_drivers.errors import ConnectionLostError

CERTIFIED = np.array([nest.centre_mm for nest in FIXED_NESTS])


async def located(cell, guesses=(), position=TRACKER_AT):
    await cell.tracker.connect()
    place = None if position is None else np.array(position)
    return await locate_tracker(cell.tracker, FIXED_NESTS, guesses, place)


@pytest.mark.parametrize("azimuth", [-3.1, -2.0, -0.4, 0.0, 0.9, 2.2, 3.1])
async def test_whatever_way_the_tracker_faces_its_frame_is_found(azimuth):
    cell = FakeCell(azimuth_rad=azimuth)

    frame = await located(cell)

    assert to_tracker(frame, CERTIFIED) == pytest.approx(cell.tracker.in_tracker(CERTIFIED), abs=1e-6)


async def test_a_tracker_that_stands_beside_its_nominal_place_is_found():
    cell = FakeCell(azimuth_rad=1.3)

    frame = await located(cell, position=np.array(TRACKER_AT) + np.array([30.0, -30.0, 20.0]))

    assert frame.translation_mm == pytest.approx(TRACKER_AT, abs=1e-6)


async def test_places_aimed_at_by_hand_need_no_search_and_no_position():
    cell = FakeCell(azimuth_rad=1.3)
    aimed = cell.tracker.in_tracker(CERTIFIED) + np.random.default_rng(0).normal(0.0, 12.0, (3, 3))

    frame = await located(cell, [(aimed, AIMED_RADIUS_MM)], position=None)

    assert cell.tracker.finds == 3
    assert frame.translation_mm == pytest.approx(TRACKER_AT, abs=1e-6)


async def test_places_that_lead_to_other_reflectors_are_given_up_for_the_search():
    cell = FakeCell(azimuth_rad=1.3)
    swapped = cell.tracker.in_tracker(CERTIFIED)[[2, 0, 1]]  # somebody aimed in another order

    frame = await located(cell, [(swapped, AIMED_RADIUS_MM)])

    assert frame.translation_mm == pytest.approx(TRACKER_AT, abs=1e-6)


async def test_an_empty_fixed_nest_is_said_so_and_nothing_is_guessed(cell):
    cell.tracker.fixed_nests = cell.tracker.fixed_nests.copy()
    cell.tracker.fixed_nests[1] += 1e5  # taken away

    with pytest.raises(ReadingRejectedError, match="each reference nest holds its reflector"):
        await located(cell)


async def test_a_lost_link_is_no_empty_place(cell):
    cell.tracker.find_faults = {4: ConnectionLostError("gone")}

    with pytest.raises(ConnectionLostError):
        await located(cell)


async def test_a_session_that_knows_neither_place_nor_aim_pauses_with_what_to_do(cell):
    cell.cell = replace(cell.cell, tracker_position_mm=None)
    operator = PatientOperator(patience=1)

    ended = await run_session(cell, make_plan(), operator)

    assert ended is SessionState.ABORTED
    assert "aim at each nest once" in operator.questions[1]
    assert cell.robot.moves == []
