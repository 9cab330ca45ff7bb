"""A tracker is warm when its readings say so: whatever a clock says."""

import numpy as np
import pytest

from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.session import FixedNestTaken, SessionState
from truepose.sessions.tracker.state import steps
from truepose.sessions.tracker.warm_up import AHEAD_S, warmth

PLAN = make_plan(2, warm_up=True)
NESTS = 3
ROUND_S = 30.0


def rounds(n, drift_mm, noise_mm=0.0, seed=1):
    """Readings of n rounds; `drift_mm(t)` is the way of every nest at that time."""
    rng = np.random.default_rng(seed)
    for number in range(n):
        for nest in range(1, NESTS + 1):
            time_s = ROUND_S * number + nest
            x, y, z = np.array([1000.0 * nest + drift_mm(time_s), 0.0, 0.0]) + noise_mm * rng.normal(size=3)
            yield FixedNestTaken("warm_up", nest, 1, time_s, (x, y, z), None, 0.01)


def found(*args, **more):
    return warmth(list(rounds(*args, **more)), PLAN, NESTS)


def test_before_there_are_rounds_nothing_is_said():
    nothing = warmth([], PLAN, NESTS)

    assert (nothing.ahead_mm, nothing.bound_mm, nothing.ready) == (None, None, False)
    assert found(7, lambda t: 0.0).ready is False  # however well they agree


def test_a_steady_drift_is_told_for_the_time_between_two_looks():
    rate = 0.02 / AHEAD_S

    drifting = found(10, lambda t: rate * t)

    assert drifting.ahead_mm == pytest.approx(0.02, abs=1e-9)  # no noise: rounding only
    assert drifting.time_s == pytest.approx(ROUND_S * np.arange(10))
    assert drifting.drift_mm == pytest.approx(rate * ROUND_S * np.arange(10))
    assert not drifting.ready  # a tenth of 0.1 mm is allowed
    assert found(10, lambda t: 0.4 * rate * t).ready


def test_the_newer_half_counts():
    decayed = found(60, lambda t: 0.2 * np.exp(-t / 200.0))

    assert max(decayed.drift_mm) > 0.19
    assert decayed.ready


def test_noise_asks_for_more_rounds_and_not_for_more_time():
    assert not found(8, lambda t: 0.0, noise_mm=0.01).ready
    assert found(60, lambda t: 0.0, noise_mm=0.01).ready


def test_a_drifting_tracker_is_seldom_called_warm():
    allowed = PLAN.reference_limit_mm / 10
    called = [found(20, lambda t: 1.5 * allowed / AHEAD_S * t, 0.005, seed).ready for seed in range(40)]

    assert sum(called) <= 4  # the bound is meant to fail in 1 of 20; 3 standard deviations more


def test_a_round_that_was_cut_counts_not():
    whole = list(rounds(9, lambda t: 0.0))

    cut = warmth([*whole[:4], *whole[3:]], PLAN, NESTS)

    assert len(cut.time_s) == 9
    assert cut.ready


def test_the_plan_lists_the_warm_up_before_the_world_frame():
    listed = [step.id for step in steps(PLAN, NESTS)]

    assert listed[:4] == ["instruments", "warm-up", "world-frame", "fixed-nests"]
    assert "warm-up" not in [step.id for step in steps(make_plan(2), NESTS)]


async def test_a_session_warms_up_until_the_readings_agree_and_only_then_registers(cell):
    assert await run_session(cell, PLAN) is SessionState.FINISHED

    phases = [taken.phase for taken in cell.journal.fixed]
    assert phases.count("warm_up") == 8 * NESTS
    assert phases.index("registration") > max(i for i, phase in enumerate(phases) if phase == "warm_up")


async def test_a_session_goes_on_warming_after_a_restart(cell):
    await run_session(cell, PLAN)
    entries = tuple(cell.journal.entries)
    cut = next(i for i, entry in enumerate(entries) if entry.fixed_nest) + 4 * NESTS
    again = FakeCell()
    again.clock.time_s = entries[cut - 1].time_s

    await run_session(again, PLAN, PatientOperator(), entries[:cut])

    before = sum(entry.fixed_nest is not None for entry in entries[:cut])
    warm = [taken for taken in again.journal.fixed if taken.phase == "warm_up"]
    assert 0 < len(warm) <= 8 * NESTS - before + NESTS  # the round that was cut is read anew
