"""Times of one weighted solution with covariance, printed as JSON: positions -> median milliseconds."""

import json
import sys
import time
from typing import Final

import numpy as np

from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.robot import FramePlacement
from truepose.exchange.robots.shipped import load_robot_with_tool
from truepose.identification.fit.robust import fit
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.observations.positions import position_block
from truepose.identification.problem.build import automatic_effects, build
from truepose.kinematics.chain import nominal_chain

_SIZES: Final = (50, 1000, 10000)
_RUNS: Final = 9
_NOISE_MM: Final = 0.015


def main() -> None:
    """Print the times."""
    sys.stdout.write(json.dumps({n: _median_ms(n) for n in _SIZES}) + "\n")


def _median_ms(n: int) -> float:
    campaign = _campaign(n)
    problem = build(campaign, automatic_effects(campaign))
    block = position_block(campaign.calibration, campaign.scatter_mm) if campaign.calibration else None
    blocks = (block,) if block else ()
    taken = []
    for _ in range(_RUNS):
        start = time.perf_counter()
        fit(problem.structure, blocks, problem.structure.prior_means)
        taken.append(1e3 * (time.perf_counter() - start))
    return float(np.median(taken))


def _campaign(n: int) -> Campaign:
    """Return an IRB 120 whose parameters are off by a fifth of their prior widths, measured with noise."""
    shipped = load_robot_with_tool("abb-irb-120")
    rng = np.random.default_rng(n)
    ranges = shipped.robot.calibration_ranges or ()
    joints = rng.uniform([r.lower_rad for r in ranges], [r.upper_rad for r in ranges], (n, len(ranges)))
    targets = Targets(Stops(np.arange(n), joints), 1 + np.arange(n) % len(shipped.nests))
    centres = np.array([nest.centre_mm for nest in shipped.nests])
    places = nominal_chain(shipped.robot, joints).points(centres[targets.nest - 1])
    readings = PointReadings(targets.stops, targets.nest, places, np.full(n, _NOISE_MM))
    nominal = Campaign(shipped.robot, FramePlacement(), shipped.nests, calibration=readings)
    structure = build(nominal, automatic_effects(nominal)).structure
    widths = np.minimum(structure.prior_widths, 1.0)
    true = structure.prior_means + 0.2 * widths * rng.standard_normal(len(widths))
    seen = evaluate(structure, true, targets).position_mm + _NOISE_MM * rng.standard_normal((n, 3))
    readings = PointReadings(targets.stops, targets.nest, seen, np.full(n, _NOISE_MM))
    return Campaign(shipped.robot, FramePlacement(), shipped.nests, calibration=readings)


if __name__ == "__main__":
    main()
