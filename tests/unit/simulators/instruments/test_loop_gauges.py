"""Gauges of simulated closed loops: where targets truly stand, and what scenarios may say."""

from dataclasses import replace

import numpy as np
import pytest

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.gauges.loop import LoopSetup, bolt_targets
from truepose_simulators.scenarios.file import load_scenario

SPHERES = LoopSetup(
    kinds=("sphere", "sphere"),
    places_mm=((420.0, -120.0, 80.0), (420.0, 120.0, 80.0)),
    zeros_mm=(16.0, 16.0),
)


def test_a_plate_is_bolted_elsewhere_and_its_spheres_stay_as_far_apart_as_its_paper_says():
    off, distances = [], []
    for seed in range(200):
        first, second = bolt_targets(SPHERES, np.random.default_rng(seed))
        off.append(first.place_mm - SPHERES.places_mm[0])
        distances.append(np.linalg.norm(second.place_mm - first.place_mm))

    assert 0.8 < np.std(off) < 1.3
    # two centres, each off by 2 um along the line between them; 5 % of a standard deviation of 200 draws
    assert np.std(distances) == pytest.approx(0.002 * np.sqrt(2.0), rel=0.2)


def test_without_uncertainty_everything_stands_where_it_was_asked_for():
    exact = replace(SPHERES, placed_u_mm=0.0, placed_u_rad=0.0, paper_u_mm=0.0)

    for target, place in zip(bolt_targets(exact, np.random.default_rng(1)), exact.places_mm, strict=True):
        assert target.place_mm == pytest.approx(place, abs=1e-12)
        assert target.zero_mm == 16.0


def test_an_arm_far_away_touches_nothing():
    cell = Cell(load_scenario("lrmate-two-spheres"), 2, CellClock(0))

    (sample,) = (gauge.sample(0.0) for gauge in cell.loop)

    assert (sample.deviation_mm, sample.signal) == (-5.5, "out_of_range")


def test_a_cell_without_a_loop_has_no_gauge_and_is_the_same_cell_as_before():
    plain, with_loop = (
        Cell(load_scenario(name), 3, CellClock(0)) for name in ("lrmate-tilted", "lrmate-wires")
    )

    assert plain.loop == ()
    assert len(with_loop.loop) == 3
    assert np.array_equal(plain.tool_nests_mm, with_loop.tool_nests_mm)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"kinds": ("plane", "wire")}, "a probe does not read a wire"),
        ({"kinds": ("sphere",)}, "places_mm"),
        ({"zeros_mm": (16.0,)}, "zeros_mm"),
        ({"paper_u_mm": -1.0}, "paper_u_mm"),
        ({"travel_mm": 0.0}, "travel_mm"),
        ({"axis": (0.0, 0.0, 0.0)}, "axis"),
        ({"normals": ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))}, "normals"),
        ({"kinds": (), "places_mm": (), "zeros_mm": ()}, "kinds"),
    ],
)
def test_a_scenario_that_cannot_be_is_told(changes, sentence):
    with pytest.raises(ScenarioError, match=sentence):
        replace(SPHERES, **changes)
