"""Parameters drawn again and again against what is known of their scatter."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import measured, nominal_campaign
from truepose.domain.errors import ConfigurationError
from truepose.identification.resampling import Resampling

DRAWS = 150
# A standard deviation of 150 draws scatters by 1 / sqrt(2 * 149) = 6 %; none of a dozen is 3.5 times that.
_OFF = 3.5 * 0.06


@pytest.fixture(scope="module")
def campaign():
    return measured(nominal_campaign(45), effects=("base", "tool"))[0]


@pytest.fixture(scope="module")
def fitted(campaign):
    return Resampling(campaign, ("base", "tool"))


def _draws(fitted, way, draws=DRAWS, seed=0):
    return [fitted.draw(way, np.random.default_rng((seed, number))) for number in range(draws)]


def test_draws_of_noise_have_the_covariance_that_is_stated(fitted):
    """Base and tool are linear within microns, so that draws are those of the posterior."""
    drawn = np.array(_draws(fitted, "noise"))

    root = np.linalg.cholesky(np.linalg.inv(fitted.fitted.solution.covariance))
    white = (drawn - fitted.fitted.values) @ root  # as many independent unit normals as there are parameters

    assert white.std(axis=0) == pytest.approx(1.0, abs=_OFF)
    assert np.abs(white.mean(axis=0)).max() < 4.0 / np.sqrt(DRAWS)
    correlation = np.corrcoef(white.T) - np.eye(white.shape[1])
    assert np.abs(correlation).max() < 4.5 / np.sqrt(DRAWS)


def test_configurations_scatter_parameters_as_noise_does_where_noise_is_all_there_is(fitted):
    """Two ways to the same: the one is told how large the noise is, the other finds it in the readings."""
    spread = fitted.spread("configurations", _draws(fitted, "configurations"))

    ratios = [one.standard_deviation / one.standard_uncertainty for one in _of_base(spread)]
    # 45 configurations tell their own scatter to 1/sqrt(90), 11 %; 6 of 57 parts go into the parameters.
    assert np.exp(np.mean(np.log(ratios))) == pytest.approx(1.0, abs=0.2)
    assert min(ratios) > 0.6
    assert max(ratios) < 1.6


def test_configurations_show_what_stated_noise_hides(campaign):
    """A robot that errs ten times as much as its readings are stated to."""
    points = campaign.calibration
    noise = 0.15 * np.random.default_rng(3).standard_normal(points.position_mm.shape)
    worse = replace(campaign, calibration=replace(points, position_mm=points.position_mm + noise))
    of_best, of_worse = (Resampling(one, ("base", "tool")) for one in (campaign, worse))

    usual = of_best.spread("configurations", _draws(of_best, "configurations", 40))
    found = of_worse.spread("configurations", _draws(of_worse, "configurations", 40))

    ratios = [
        one.standard_deviation / other.standard_deviation
        for one, other in zip(_of_base(found), _of_base(usual), strict=True)
    ]
    assert 6.0 < np.exp(np.mean(np.log(ratios))) < 15.0


def _of_base(spread):
    return [one for one in spread.parameters if one.effect == "base"]


def test_readings_that_say_nothing_leave_the_prior_by_noise_and_no_scatter_by_configurations():
    """Where the right answer is nothing: readings of ten metres beside priors of tenths of a millimetre."""
    campaign = measured(nominal_campaign(15), noise_mm=5.0)[0]
    points = campaign.calibration
    vague = replace(points, standard_uncertainty_mm=np.full(len(points), 1e4))
    fitted = Resampling(replace(campaign, calibration=vague), ("base", "geometry"))
    geometry = [k for k, owner in enumerate(fitted.fitted.structure.owners) if owner == "geometry"]
    widths = fitted.fitted.structure.prior_widths[geometry]

    by_noise = np.array(_draws(fitted, "noise", 60))[:, geometry].std(axis=0) / widths
    by_configurations = np.array(_draws(fitted, "configurations", 20))[:, geometry].std(axis=0) / widths

    assert np.exp(np.mean(np.log(by_noise))) == pytest.approx(1.0, abs=0.1)
    assert by_configurations.max() < 0.05


def test_a_draw_depends_on_its_seed_alone(fitted):
    first, again, other = (fitted.draw("configurations", np.random.default_rng(seed)) for seed in (3, 3, 4))

    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_readings_of_one_configuration_are_drawn_together(campaign):
    """Each reading twice is one reading with half the variance, not a campaign twice as long."""
    points = campaign.calibration
    twice = points.taken(np.repeat(np.arange(len(points)), 2))
    doubled = replace(twice, standard_uncertainty_mm=twice.standard_uncertainty_mm * np.sqrt(2.0))
    of_one, of_two = (
        Resampling(replace(campaign, calibration=readings), ("base", "tool"))
        for readings in (points, doubled)
    )

    single = of_one.draw("configurations", np.random.default_rng(1))
    pairs = of_two.draw("configurations", np.random.default_rng(1))

    assert pairs == pytest.approx(single, abs=1e-6)


def test_too_few_configurations_or_draws_say_nothing(fitted):
    with pytest.raises(ConfigurationError, match="Resample the noise"):
        Resampling(measured(nominal_campaign(8), effects=("base",))[0], ("base",)).draw(
            "configurations", np.random.default_rng(0)
        )
    with pytest.raises(ConfigurationError, match="Only 2 of 12 draws converged"):
        fitted.spread("noise", [None] * 10 + _draws(fitted, "noise", 2))
