"""Cells without a name, hidden in a simulated arm by mechanics of their own: found, and described rightly."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.causes_without_a_name import (
    Creeping,
    Hose,
    Line,
    SoftFlange,
    assert_flange_told,
    assert_last_move_told,
    assert_line_told,
)
from tests.helpers.diagnosis.hidden_causes import recorded
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.diagnosis import Verdict
from truepose.messages.catalogue import english


@pytest.mark.parametrize(
    ("joint", "order", "readings", "seed"),
    [(2, 7.4, 150, 1), (2, 7.4, 150, 21), (6, 16.67, 100, 6), (1, 21.5, 150, 5)],
)
def test_a_line_between_whole_orders_is_told_with_its_order(joint, order, readings, seed, tmp_path):
    """Joint 6 leaves so many waves beside it that they are first a curve."""
    campaign = recorded(tmp_path, Line(joint, order, 0.02), seed=seed, configurations=readings)

    assert_line_told(diagnose(campaign), joint, order)


@pytest.mark.parametrize(("joint", "order", "readings", "seed"), [(2, 7, 150, 2), (3, 11, 100, 7)])
def test_a_wave_of_a_whole_order_stays_one(joint, order, readings, seed, tmp_path):
    campaign = recorded(tmp_path, Line(joint, order, 0.02), seed=seed, configurations=readings)

    (finding,) = diagnose(campaign).findings

    assert (finding.details[0].value, finding.details[0].standard_uncertainty) == (order, 0.0)


def joints_named(text):
    return {int(number) for number in re.findall(r"\d+", text)}


@pytest.mark.parametrize(
    ("pull_n", "body", "clip_mm", "seed"),
    [
        (30.0, 3, (0.0, 80.0, 680.0), 12),
        (30.0, 4, (250.0, 80.0, 680.0), 11),
        (30.0, 5, (302.0, 80.0, 680.0), 15),
    ],
)
def test_a_hose_is_told_by_the_joints_that_it_pulls_and_never_given_a_sure_name(
    pull_n, body, clip_mm, seed, tmp_path
):
    """No cell is a hose: what it does follows the angles between its clips, and so says the answer."""
    hose = Hose(pull_n, body, clip_mm, (-100.0, 0.0, 300.0))

    diagnosis = diagnose(recorded(tmp_path, hose, seed=seed))

    first = diagnosis.findings[0]
    assert "angle" in first.over
    assert joints_named(first.where) | joints_named(first.over) <= set(range(1, body + 1))
    sure = [one for one in diagnosis.findings if one.confidence == "certain"]
    assert {one.effect for one in sure} <= {"unnamed"}
    assert all(joints_named(one.where) <= set(range(1, body + 1)) for one in sure)
    assert diagnosis.after.mean_mm < 0.8 * diagnosis.before.mean_mm


def test_a_hose_on_the_tool_passes_for_a_load_and_is_not_sure(tmp_path):
    hose = Hose(30.0, 6, (374.0, 80.0, 680.0), (-100.0, 0.0, 300.0))

    diagnosis = diagnose(recorded(tmp_path, hose, seed=16))

    assert diagnosis.verdict is Verdict.PARTLY_EXPLAINED
    assert {one.confidence for one in diagnosis.findings} == {"likely"}


@pytest.mark.parametrize(("about_x", "about_y", "seed"), [(1.5e-7, 1.5e-7, 11), (0.0, 2e-7, 13)])
def test_a_flange_that_gives_under_the_tool_is_told_by_its_load(about_x, about_y, seed, tmp_path):
    diagnosis = diagnose(recorded(tmp_path, SoftFlange(about_x, about_y), seed=seed))

    assert_flange_told(diagnosis, about_x, about_y)


def test_a_joint_of_the_wrist_that_has_not_settled_is_told_by_its_last_move(tmp_path):
    diagnosis = diagnose(recorded(tmp_path, Creeping(4, 5e-4), seed=12))

    assert_last_move_told(diagnosis, 4, 5e-4)


def written_with(decimals, points):
    """Readings beside joint angles that were written down in degrees with so many decimals."""
    joints_rad = np.radians(np.round(np.degrees(points.stops.joints_rad), decimals))
    return replace(points, stops=replace(points.stops, joints_rad=joints_rad))


@pytest.mark.parametrize(("decimals", "seed"), [(1, 12), (2, 702)])
def test_angles_with_few_digits_are_told_to_be_the_noise(decimals, seed, tmp_path):
    exact = recorded(tmp_path, seed=seed)
    campaign = replace(
        exact,
        calibration=written_with(decimals, exact.calibration),
        validation=written_with(decimals, exact.validation),
    )

    diagnosis = diagnose(campaign)

    assert diagnosis.verdict is Verdict.CONSISTENT
    assert f"the joint angles are rounded to steps of {0.1**decimals:g} deg" in english(diagnosis.message)
    assert english(diagnosis.message).endswith("Provide the angles with all their digits.")


def test_an_arm_that_settles_has_nothing_of_it(tmp_path):
    diagnosis = diagnose(recorded(tmp_path, seed=14))

    assert diagnosis.verdict is Verdict.CONSISTENT
