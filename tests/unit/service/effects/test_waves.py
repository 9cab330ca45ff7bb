"""Waves of a joint's angle: what they turn, and how one, several and a whole curve of them are told."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    START,
    fitted,
    telling_campaign,
    telling_problem,
    telling_scene,
)
from tests.helpers.domain.robots import IRB_120
from truepose.effects.ports import ParameterSpec
from truepose.effects.registry import CAUSES
from truepose.effects.waves import spectrum
from truepose.identification.model.evaluation import evaluate


@pytest.mark.parametrize(
    ("order", "typical"),
    [
        (1.0, "out_of_true"),
        (2.0, "oval"),
        (3.0, "repeats"),
        (7.25, "inside_the_gear"),
        (121.0, "motor"),
        (242.0, "wave_generator"),
    ],
)
def test_a_wave_is_told_with_its_size_its_phase_and_what_usually_has_it(order, typical):
    scene = telling_scene(START, telling_campaign(robot=replace(IRB_120, gear_ratios=(121.0,) * 6)))
    unit = np.deg2rad(0.01)
    wave = fitted((f"wave_3_{order:g}_cos", 4 * unit), (f"wave_3_{order:g}_sin", 3 * unit))

    shown = CAUSES["joint_harmonics"].describe("joint 3", wave, scene)

    assert (shown.amplitude, shown.unit) == (pytest.approx(0.05), "deg")
    told = {detail.name: detail.value for detail in shown.details}
    assert told == {"order": order, "phase": pytest.approx(np.degrees(np.arctan2(4, 3)))}
    assert dict(shown.sentence.values)["typical"].key == f"typical.{typical}"


def test_of_several_waves_the_largest_is_told_and_each_has_its_row():
    unit = np.deg2rad(0.01)
    waves = [
        (f"wave_3_{order}_{part}", size * unit)
        for order, size in ((5, 3.0), (2, 4.0))
        for part in ("sin", "cos")
    ]
    found = fitted(*waves, spread=0.1 * unit)

    shown = CAUSES["joint_harmonics"].describe("joint 3", found, telling_scene())
    lines = spectrum(found)

    amplitude = 0.01 * np.sqrt(2) * np.sqrt([16.0 - 0.005, 9.0 - 0.005])  # less what noise across adds
    assert lines.order.tolist() == [2.0, 5.0]
    assert lines.amplitude_deg == pytest.approx(amplitude)
    assert lines.standard_uncertainty_deg == pytest.approx(0.001 * 0.01 * np.sqrt([32.0, 18.0]) / amplitude)
    assert shown.amplitude == pytest.approx(amplitude[0])
    assert dict(shown.sentence.values)["orders"] == ("2", "5")
    assert [detail.name for detail in shown.details] == ["order", "amplitude", "phase"] * 2


def test_a_curve_of_many_waves_is_told_by_half_of_peak_to_peak_within_what_was_measured():
    unit = np.deg2rad(0.01)
    sizes = {(1, "sin"): 5.0} | {(order, "cos"): 1e-9 for order in range(2, 27)}
    names = [(order, part) for order in range(1, 27) for part in ("sin", "cos")]
    found = fitted(
        *((f"wave_3_{order}_{part}", sizes.get((order, part), 0.0) * unit) for order, part in names)
    )
    scene = telling_scene()

    shown = CAUSES["joint_harmonics"].describe("joint 3", found, scene)

    angle = np.linspace(scene.turn_rad[:, 2].min(), scene.turn_rad[:, 2].max(), 5000)
    assert shown.amplitude == pytest.approx(0.05 * np.ptp(np.sin(angle)) / 2, rel=1e-5)
    assert shown.sentence.key == "causes.joint_harmonics.curve"
    assert dict(shown.sentence.values)["orders"][0] == "1"
    assert len(dict(shown.sentence.values)["orders"]) == 5
    assert len(shown.details) == 15


@pytest.mark.parametrize("count", [3, 40])
def test_waves_turn_their_joint_by_the_sum_of_sines_and_cosines(count):
    campaign = telling_campaign()
    values = {
        f"wave_4_{order}_{part}": 1e-4 * (order + len(part) / 7 * (part == "sin"))
        for order in range(1, count + 1)
        for part in ("sin", "cos")
    }
    problem = telling_problem(("base",))
    specs = tuple(ParameterSpec(name, "rad", 0.0, 1.0) for name in values)
    structure = problem.structure.extended("joint_harmonics", specs)
    full = np.concatenate([problem.start, list(values.values())])

    moved = evaluate(structure, full, problem.blocks[0].targets).chain.end_rotation

    turn = campaign.calibration.stops.joints_rad[:, 3]
    waves = {"sin": np.sin, "cos": np.cos}
    away = sum(value * waves[name[-3:]](int(name.split("_")[2]) * turn) for name, value in values.items())
    joints = campaign.calibration.stops.joints_rad.copy()
    joints[:, 3] += IRB_120.joints[3].sign * away
    turned = replace(
        problem.blocks[0].targets, stops=replace(problem.blocks[0].targets.stops, joints_rad=joints)
    )
    assert moved == pytest.approx(evaluate(problem.structure, problem.start, turned).chain.end_rotation)
