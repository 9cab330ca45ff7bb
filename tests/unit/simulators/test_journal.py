"""A cell that is started anew with its journal stands where it stood."""

import json

import numpy as np
import pytest

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.journal import RememberedCell
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError
from truepose_simulators.errors import HandsError, JournalError
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.scenarios.file import load_scenario

LIMITS, TOOL_MM = SpeedLimits(), np.array([75.0, 93.675, 215.0])
FRAME = {"x_mm": 300.0, "y_mm": -200.0, "z_mm": 0.0, "rx_deg": 0.0, "ry_deg": 0.0, "rz_deg": 0.0}


async def started(path, seed=4, scenario="lrmate-clean") -> RememberedCell:
    cell = RememberedCell(load_scenario(scenario), seed, CellClock(0))
    await cell.remember(path)
    return cell


async def moved(cell, joints_deg) -> None:
    await cell.move_robot([np.radians(joints_deg)], LIMITS, TOOL_MM)


async def some_work(cell) -> None:
    """Bars, a base fixture with one cup clamped where the arm holds the ball, and the bar on the tool."""
    cell.do("place_base", {"placement": 1})
    cell.do("fit_ball", {})
    await moved(cell, [10.0, 30.0, -40.0, 20.0, -60.0, 0.0])
    cell.do("clamp", {"base_point": 1})
    await moved(cell, [40.0, 10.0, -40.0, 20.0, -60.0, 0.0])
    cell.do("remove_ball", {})
    cell.do("calibrator", {"bars": "tool"})
    await cell.clock.sleep(12.5)
    cell.do("side", {"artefact": "tool", "a": 1, "b": 2})


def standing(cell) -> dict[str, object]:
    """Everything of a cell that a session notices."""
    now_s = cell.clock.now_s
    return {
        "now_s": now_s,
        "joints": cell.robot.motion.joints_at(now_s).tolist(),
        "direction": cell.robot.direction.tolist(),
        "scatter": cell.robot.scatter_mm.tolist(),
        "cups": [(cup.placement, cup.base_point, cup.place_mm.tolist()) for cup in cell.fixture.cups],
        "bars": cell.ballbar.bars,
        "seat": cell.ballbar.seat(now_s),
        "plugged": cell.ballbar.plugged,
        "ball_fitted": cell.hands.ball_fitted,
        "attachment": cell.attachment,
        "effects": [change.name for change in cell.planted.changes],
    }


async def test_what_stood_stands_again(tmp_path):
    first = await started(tmp_path / "cell.json")
    await some_work(first)
    first.do("pull_cable", {})
    first.mount_tool_anew()
    first.plant_change(PlantedChange("joint_gain", "joint 2", 1e-3, 0.0, {}))
    before = standing(first)

    again = await started(tmp_path / "cell.json")

    assert standing(again) == before


async def test_the_zero_and_the_cups_are_the_same_to_the_last_digit(tmp_path):
    first = await started(tmp_path / "cell.json")
    await some_work(first)
    again = await started(tmp_path / "cell.json")

    shown = [
        np.mean([cell.ballbar.sample(cell.clock.now_s).deviation_mm for _ in range(200)])
        for cell in (first, again)
    ]

    # the two draw other noise: 0.51 um over sqrt(200), twice, and 5 sigma of it
    assert abs(shown[0] - shown[1]) < 5.0 * np.sqrt(2.0 / 200.0) * 0.00051


async def test_it_goes_on_from_there_and_can_be_started_again(tmp_path):
    for _ in range(3):
        cell = await started(tmp_path / "cell.json")
        await moved(cell, np.degrees(cell.robot.target_rad) + 5.0)

    again = await started(tmp_path / "cell.json")

    assert np.degrees(again.robot.target_rad) == pytest.approx(np.degrees(again_from(cell)), abs=1e-9)
    assert again.robot.stop_number == 3


def again_from(cell) -> np.ndarray:
    return cell.robot.target_rad


async def test_a_motion_under_way_is_finished(tmp_path):
    first = await started(tmp_path / "cell.json")
    motion = first.set_off([np.radians([10.0] * 6)], LIMITS, TOOL_MM)  # killed before it arrives

    again = await started(tmp_path / "cell.json")

    assert not again.robot_moves
    assert again.clock.now_s >= motion.duration_s
    assert np.degrees(again.robot.motion.joints_at(again.clock.now_s)) == pytest.approx([10.0] * 6)


async def test_what_was_refused_is_not_written_down(tmp_path):
    first = await started(tmp_path / "cell.json")

    with pytest.raises(HandsError):
        first.do("connect", {"base": 1, "tool": 1})
    with pytest.raises(TargetOutOfRangeError):
        await moved(first, [999.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    assert len((tmp_path / "cell.json").read_text().splitlines()) == 1


@pytest.mark.parametrize("cut", [1, 7])
async def test_a_line_that_was_cut_off_counts_for_nothing(tmp_path, cut):
    path = tmp_path / "cell.json"
    first = await started(path)
    first.do("fit_ball", {})
    first.do("remove_ball", {})
    path.write_bytes(path.read_bytes()[:-cut])

    again = await started(path)
    assert again.hands.ball_fitted
    again.do("remove_ball", {})

    assert not (await started(path)).hands.ball_fitted


@pytest.mark.parametrize("other", [{"seed": 5}, {"scenario": "lrmate-tilted"}])
async def test_the_journal_of_another_cell_is_begun_anew(tmp_path, other):
    first = await started(tmp_path / "cell.json")
    first.do("fit_ball", {})

    again = await started(tmp_path / "cell.json", **other)

    assert not again.hands.ball_fitted


async def test_an_entry_that_cannot_be_done_again_is_named(tmp_path):
    path = tmp_path / "cell.json"
    first = await started(path)
    first.do("fit_ball", {})
    with path.open("a") as file:
        file.write(json.dumps({"time_s": 1.0, "did": "deed", "action": "fit_ball", "details": {}}) + "\n")

    with pytest.raises(JournalError, match=r"line 3: .*delete the file"):
        await started(path)


async def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(JournalError, match="cannot be saved"):
        await started(tmp_path / "none" / "cell.json")
