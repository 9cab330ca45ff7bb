import numpy as np
import pytest

from truepose_simulators.cell.drawn_effects import CurveSizes, draw_curves
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.recording.files import campaign_document
from truepose_simulators.scenarios.file import load_scenario

ARM = ARMS["irb120"]
USUAL = CurveSizes()


def lines_of(sizes=USUAL, seed=4):
    return draw_curves(sizes, ARM, np.random.default_rng(seed))


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_a_joint_is_off_by_what_is_stated_from_peak_to_peak(joint):
    turn = np.linspace(-np.pi, np.pi, 7919)
    lines = [line for line in lines_of() if line.subject == f"joint {joint}"]
    curve = sum(
        line.amplitude * np.sin(line.details["order"] * turn + np.radians(line.details["phase_deg"]))
        for line in lines
    )

    assert len(lines) == 25
    assert np.ptp(curve) == pytest.approx(0.07, rel=0.01)


def test_orders_lie_in_their_band_and_some_are_not_whole():
    orders = np.array([line.details["order"] for seed in range(20) for line in lines_of(seed=seed)])

    assert orders.min() >= 5.0
    assert orders.max() <= 60.0
    assert 0.15 < np.mean(orders != np.round(orders)) < 0.25


def test_no_line_is_large():
    assert max(line.amplitude for line in lines_of()) < 0.02


def test_the_cell_is_the_tilted_one_with_curves_and_its_papers_state_no_gear_ratio():
    curved, tilted = (Cell(load_scenario(f"irb120-{name}"), 3, CellClock(0)) for name in ("curves", "tilted"))

    assert np.array_equal(curved.plant.motions, tilted.plant.motions)
    assert {change.subject for change in curved.planted.changes} == {"joint 1", "joint 2", "joint 3"}
    assert "gear_ratio" not in campaign_document(curved, {})
    assert "gear_ratio" in campaign_document(tilted, {})


@pytest.mark.parametrize(
    "changes", [{"orders": (0.0, 60.0)}, {"orders": (9.0, 5.0)}, {"lines": 0}, {"share_not_whole": 1.1}]
)
def test_sizes_that_cannot_be_are_refused(changes):
    with pytest.raises(ScenarioError):
        CurveSizes(**changes)


def test_a_joint_that_the_arm_does_not_have_is_refused():
    with pytest.raises(ScenarioError, match="from 1 to 6"):
        lines_of(CurveSizes(joints=(7,)))
