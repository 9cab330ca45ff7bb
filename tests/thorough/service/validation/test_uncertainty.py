"""Stated uncertainties of figures against the scatter of the figures themselves, over drawn measurements."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.framed import FRAME, U_MM, model_with_frame, readings
from truepose.identification import judge
from truepose.identification.verdict.relative_accuracy import relative_errors
from truepose.validation.distance_errors import distances
from truepose.validation.validate import validate

DRAWS = 250
FIGURES = ("mean_mm", "rms_mm", "sd_mm")


def blocks(model, points):
    judged = judge(model, points, 0.0)
    return {
        "position": judged.pair(),
        "relative": relative_errors(judged),
        "distance": distances(judged).sizes,
        "signed": distances(judged).errors.identified.mean_mm,
    }


def measured_again(points, rng):
    """The same places, read anew in a frame set up anew."""
    x, y, turn = (u * rng.standard_normal() for _, u in FRAME)
    frame = np.array([x, y, 0.0]) + turn * np.cross([0.0, 0.0, 1.0], points.position_mm)
    noise = U_MM * rng.standard_normal(points.position_mm.shape)
    return replace(points, position_mm=points.position_mm + frame + noise)


@pytest.fixture(scope="module")
def drawn():
    """Figures of many measurements of the same places, and what one of them says of its own."""
    model, points, rng = model_with_frame(), readings(40), np.random.default_rng(7)
    found = [blocks(model, measured_again(points, rng)) for _ in range(DRAWS)]
    return found, validate(model, measured_again(points, rng)).uncertainty


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("block", ["position", "relative", "distance"])
def test_a_stated_uncertainty_is_the_scatter_of_the_figure(drawn, block, figure):
    found, stated = drawn

    scatter = np.std([getattr(one[block].identified, figure) for one in found], ddof=1)

    # 250 draws know a scatter to 4.5 %; the rest is that one measurement is not at the true place
    assert getattr(getattr(stated, block).identified, figure) == pytest.approx(scatter, rel=0.2)


def test_the_mean_of_distances_with_sign_too(drawn):
    found, stated = drawn

    scatter = np.std([one["signed"] for one in found], ddof=1)

    assert stated.distance.identified.signed_mean_mm == pytest.approx(scatter, rel=0.2)
