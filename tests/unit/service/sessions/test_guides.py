"""What a tablet shows of a session follows from its plan and its ledger, whatever stands in it."""

import asyncio
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.service.sessions.tracker.fakes import FIXED_NESTS, IRB120, NESTS, FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.cell import Cell
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import PlannedStop, SessionState, stop_id
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.guide.guide import Fixed, standing
from truepose.sessions.guide.reading_tables import sheet_of
from truepose.sessions.guide.scene import guided_scene
from truepose.storage.records import SessionSetup

PLAN = make_plan(5, reference_every=2, registration_readings=2, warm_up=True)
CELL = Cell(
    name="bench",
    robot_key="abb-irb-120",
    robot=IRB120,
    nests=NESTS,
    fixed_nests=FIXED_NESTS,
    tracker_position_mm=(2600.0, -700.0, 500.0),
)
FIXED = Fixed("left arm", "calibration", SessionSetup(CELL), PLAN)
CONFIGS = [stop.config for stop in PLAN.stops]


@pytest.fixture(scope="module")
def entries():
    """The ledger of a whole session."""
    cell = FakeCell()
    asyncio.run(run_session(cell, PLAN, PatientOperator()))
    return tuple(cell.journal.entries)


def line(kind, step_id="", **said):
    return LedgerEntry(step_id, kind, 1.0, **said)


_STATES = [
    SessionState.RUNNING,
    SessionState.PAUSED,
    SessionState.AWAITING_CONFIRMATION,
    SessionState.PAUSING,
]
_STEPS = st.sampled_from([stop_id(config) for config in CONFIGS])
_NAMED = st.sampled_from(["warm-up", "world-frame", "fixed-nests"])
_LINES = st.one_of(
    st.builds(lambda id: line(EntryKind.MEASURED, id), _STEPS),
    st.builds(
        lambda id, key: line(EntryKind.SKIPPED, id, text="why", key=key), _STEPS, st.sampled_from([None, "k"])
    ),
    st.builds(lambda id: line(EntryKind.REOPENED, id), st.one_of(_STEPS, _NAMED)),
    st.builds(lambda id: line(EntryKind.BEGUN, id), st.one_of(_STEPS, _NAMED)),
    st.builds(
        lambda id: line(EntryKind.ENDED, id), st.sampled_from(["instruments", "warm-up", "fixed-nests"])
    ),
    st.builds(lambda: line(EntryKind.COMPUTED, "world-frame")),
    st.builds(
        lambda state: line(EntryKind.CONTROL, entered=state, stops=tuple(CONFIGS)), st.sampled_from(_STATES)
    ),
    st.builds(lambda: line(EntryKind.CONTROL, control=Control.RESTARTED)),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(_LINES, max_size=40), st.booleans())
def test_every_ledger_has_its_page(lines, runs):
    found, sheet = standing(FIXED, lines, runs=runs), sheet_of(FIXED, lines)

    statuses = [row.status for row in sheet.points]
    assert [row.config for row in sheet.points] == CONFIGS
    assert statuses.count("measured") == found.progress.done
    assert statuses.count("failed") + statuses.count("left_out") == found.progress.skipped
    assert all(row.actual_mm is None for row in sheet.points)  # nothing was read: nothing is filled in
    assert all(row.reason for row in sheet.points if row.status == "left_out")
    assert found.state is not SessionState.RUNNING or runs
    assert {CommandName.CONFIRM, CommandName.RESUME} & found.acts <= _that_let_it_go_on(found.state)


def _that_let_it_go_on(state):
    by_state = {
        SessionState.AWAITING_CONFIRMATION: {CommandName.CONFIRM},
        SessionState.PAUSED: {CommandName.RESUME},
    }
    return by_state.get(state, set())


def test_a_ledger_may_be_cut_anywhere(entries):
    for end in range(len(entries)):
        found, sheet = standing(FIXED, entries[:end], runs=True), sheet_of(FIXED, entries[:end])
        assert sum(row.status == "measured" for row in sheet.points) == found.progress.done
        assert all((row.actual_mm is not None) == (row.status == "measured") for row in sheet.points)


def test_the_tables_say_what_the_session_read(entries):
    sheet = sheet_of(FIXED, entries)

    for row in sheet.points:
        # the fake arm errs by that much; rounding of doubles at 3 m, and of the table to nanometres
        assert row.delta_mm == pytest.approx((1.5, -2.0, 1.0), abs=2e-6)
    assert [nest.readings for nest in sheet.nests] == [2, 2, 2]
    assert sheet.warmth.ready
    assert len(sheet.looks) == 4  # first, after two stops each, last
    assert all(look.holds for look in sheet.looks)


def test_a_nest_that_moved_is_told(entries):
    moved = [_shifted(entry) for entry in entries]

    look = sheet_of(FIXED, moved).looks[-1]

    assert not look.holds
    assert look.worst_mm == pytest.approx(0.3, abs=1e-6)


def _shifted(entry):
    taken = entry.fixed_nest
    if taken is None or taken.fixed_nest != 2 or taken.position_world_mm is None:
        return entry
    x, y, z = taken.position_world_mm
    return replace(entry, fixed_nest=replace(taken, position_world_mm=(x + 0.3, y, z)))


def seen_by(cell, *stops, registration=None):
    plan = replace(PLAN, stops=stops or PLAN.stops)
    return guided_scene(replace(FIXED, setup=SessionSetup(cell), plan=plan), registration, None)


def test_what_faces_away_is_hidden_and_a_better_place_is_named():
    towards_x = tuple(replace(nest, facing=(1.0, 0.0, 0.0)) for nest in NESTS)
    cell = replace(CELL, nests=towards_x)
    stop = PlannedStop(1, (0.0, 0.5, 0.0, 0.0, 0.2, 0.0), 1)
    stops = [replace(stop, config=n, joints_rad=(0.05 * n, *stop.joints_rad[1:])) for n in range(1, 6)]

    hidden = seen_by(replace(cell, tracker_position_mm=(-1500.0, 2200.0, 300.0)), *stops)

    assert {point.hidden for point in hidden.stops} <= {"turned_away", "behind_column"}


def test_every_configuration_in_sight_needs_no_better_place():
    scene = seen_by(CELL)

    assert [point.hidden for point in scene.stops] == [None] * 5  # these nests face everywhere
    assert scene.better is None


@pytest.mark.parametrize(
    ("place", "why"), [((600.0, -900.0, 300.0), "too_near"), ((1500.0, 0.0, 2800.0), "too_steep")]
)
def test_the_head_has_its_limits(place, why):
    scene = seen_by(replace(CELL, tracker_position_mm=place))

    assert why in {nest.hidden for nest in scene.fixed_nests}


def test_a_cell_that_does_not_say_where_the_tracker_stands_hides_nothing():
    scene = seen_by(replace(CELL, tracker_position_mm=None))

    assert scene.instrument_mm is None
    assert {point.hidden for point in (*scene.stops, *scene.fixed_nests)} == {None}
