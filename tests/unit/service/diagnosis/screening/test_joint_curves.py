"""Joints that are off by dozens of lines: one curve, not the few waves that come nearest."""

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import PRESENT, planted, select_from, started, those_of
from truepose.diagnosis.baseline_fit import scene_of
from truepose.diagnosis.diagnose import diagnose
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.selection import reselect
from truepose.diagnosis.screening.significance import screen
from truepose.effects.registry import CAUSES
from truepose.messages.catalogue import english


def lines(joint, count, seed, size_deg):
    """Waves of drawn orders between 5 and 60, some of them not whole, as parameters of the model."""
    rng = np.random.default_rng(seed)
    orders = np.where(rng.random(count) < 0.2, rng.uniform(5, 60, count), rng.integers(5, 61, count))
    return {
        f"wave_{joint}_{order:g}_{part}": np.deg2rad(size_deg) * rng.standard_normal()
        for order in orders
        for part in ("sin", "cos")
    }


def campaign_of(values, n=200):
    return planted({"joint_harmonics": values}, telling_campaign(n))


@pytest.fixture(scope="module")
def found():
    return diagnose(campaign_of(lines(1, 25, seed=2, size_deg=0.006)), PRESENT)


def test_a_joint_with_dozens_of_lines_is_found_as_one_curve(found):
    assert [(finding.effect, finding.subject) for finding in found.findings] == [
        ("joint_harmonics", "joint 1")
    ]
    assert len(found.findings[0].parameters) == 120
    assert "that depends on its angle" in english(found.findings[0].sentence)
    assert not found.remaining.structure


def test_its_curve_helps_readings_that_it_never_saw(found):
    assert found.after.rms_mm < 0.5 * found.before.rms_mm


def test_its_largest_waves_are_told_with_their_sizes(found):
    names = [detail.name for detail in found.findings[0].details]

    assert names == ["order", "amplitude", "phase"] * 5


def test_a_curve_is_drawn_finely_enough_for_its_fastest_wave(found):
    curve = found.findings[0].curve

    assert np.diff(curve.line_x).max() < 360.0 / 60.0 / 3.0
    assert np.ptp(curve.line) > 0.02


def test_a_few_waves_are_told_one_by_one():
    values = {"wave_1_2_sin": 3e-4, "wave_1_2_cos": 0.0, "wave_1_9_sin": 2e-4, "wave_1_9_cos": 1e-4}

    found = diagnose(campaign_of(values, n=60), PRESENT)

    assert {len(finding.parameters) for finding in found.findings} == {2}
    assert {finding.subject for finding in found.findings} == {"joint 1"}


def test_a_selection_with_a_curve_settles_though_its_size_is_told_anew_each_time():
    start = started(campaign_of(lines(1, 25, seed=2, size_deg=0.006), n=120))
    propose = those_of(start, "joint_harmonics")
    selected = select_from(start, propose)
    assert selected.picks[0].function

    again = reselect(start.fit, selected, selected.picks, propose)

    assert again.picks[0].names == selected.picks[0].names


def test_a_curve_that_was_sized_may_still_grow_to_what_physics_allows():
    start = started(campaign_of(lines(1, 25, seed=2, size_deg=0.006)))
    proposed = CAUSES["joint_harmonics"].candidates(scene_of(start.problem, start.fit))
    curve = next(one for one in proposed if one.function and one.subject == "joint 1")

    wide, small = (
        screen(pool_candidates(start.fit, (one,)).view()).width[0] for one in (curve, curve.sized(0.01))
    )

    assert 0.01 * small == pytest.approx(wide, rel=0.25)  # a step of the grid
