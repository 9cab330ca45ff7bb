"""Whether the figures of a validation are known as well as they say: the same places, measured many times.

`python -m tests.studies.figure_uncertainty` calibrates simulated robots, lets each be validated at
measured places, and draws readings of these again and again, with other noise and in a frame that is set
up anew within what the model says of its own. Printed is the scatter of every figure over what one of these
validations states of it: 1 where the statement is right, below where it is cautious.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from tests.studies.running import study_options
from tests.studies.simulated_arms import read_back
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.identification import Model
from truepose.domain.validation import FigureUncertainty, Validation
from truepose.identification import identify, judge
from truepose.validation.uncertainty import known
from truepose.validation.validate import validate
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

_FIGURES: Final = ("mean_mm", "rms_mm", "sd_mm", "max_mm")
_BLOCKS: Final = ("position", "relative", "distance")


def main() -> int:
    """Print a line per block and model: the ratio of each figure, over all robots."""
    options = study_options(
        __doc__, scenario="irb120-everyday", seeds=5, configurations=60, validation=40, draws=200
    )
    found = [_ratios(seed, options) for seed in range(1, options.seeds + 1)]
    for block in _BLOCKS:
        for model in ("nominal", "identified"):
            each = np.sqrt(np.mean([one[block, model] for one in found], axis=0))
            told = ", ".join(f"{name[:-3]} {ratio:.2f}" for name, ratio in zip(_FIGURES, each, strict=True))
            sys.stdout.write(f"{block:9s} {model:10s} {told}\n")
    return 0


def _ratios(seed: int, options: argparse.Namespace) -> dict[tuple[str, str], np.ndarray]:
    """Return the squared ratios of one robot, four per block and model."""
    campaign = _campaign(seed, options)
    model, points = identify(campaign).model, campaign.validation
    if model is None or points is None:
        raise SystemExit("no model")
    drawn = [validate(model, again) for again in _measured_again(model, points, seed, options.draws)]
    return {
        (block, which): np.array([_scatter(drawn, block, which, name) for name in _FIGURES]) ** 2
        for block in _BLOCKS
        for which in ("nominal", "identified")
    }


def _campaign(seed: int, options: argparse.Namespace) -> Campaign:
    recording = record(
        load_scenario(options.scenario).quiet(),
        seed,
        RecordingRequest(options.configurations, options.validation),
    )
    return read_back(recording)


def _measured_again(model: Model, points: PointReadings, seed: int, draws: int) -> Iterator[PointReadings]:
    inputs, rng = known(model, judge(model, points, model.repeatability_mm)), np.random.default_rng((seed, 3))
    roots = np.linalg.cholesky(inputs.covariance)
    for _ in range(draws):
        frame = rng.multivariate_normal(np.zeros(len(inputs.placement)), inputs.placement)
        noise = np.einsum("nij,nj->ni", roots, rng.standard_normal(points.position_mm.shape))
        moved = points.position_mm + noise + np.tensordot(frame, inputs.motion, 1)
        yield replace(points, position_mm=moved)


def _scatter(drawn: list[Validation], block: str, which: str, figure: str) -> float:
    values = [getattr(getattr(getattr(one, block), which), figure) for one in drawn]
    stated = [getattr(_stated(one, block, which), figure) for one in drawn]
    return float(np.std(values, ddof=1) / np.sqrt(np.mean(np.square(stated))))


def _stated(answer: Validation, block: str, which: str) -> FigureUncertainty:
    found: FigureUncertainty = getattr(getattr(answer.uncertainty, block), which)
    return found


if __name__ == "__main__":
    sys.exit(main())
