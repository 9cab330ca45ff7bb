"""What a campaign tells, against the fit that it comes from."""

import numpy as np
import pytest

from tests.helpers.fleet.recorded import recorded_campaign
from truepose.domain.errors import ConfigurationError
from truepose.fleet.campaigns import FleetCampaign, fleet_effects, fleet_of, information_of, with_gear_waves
from truepose.identification.fit.robust import robust_fit
from truepose.identification.problem.build import build


@pytest.fixture(scope="module")
def campaign():
    return recorded_campaign(30)


def test_with_its_priors_again_it_gives_what_was_identified(campaign):
    problem = with_gear_waves(build(campaign, fleet_effects(campaign)), campaign.robot)
    fitted = robust_fit(problem.structure, problem.blocks, problem.start)
    value = dict(zip(fitted.structure.names, fitted.values, strict=True))
    width = {spec.name: spec.prior_width for spec in fitted.structure.specs}  # widened, where the data asked

    told = information_of(campaign)

    means = np.array([spec.prior_mean for spec in told.specs])
    precision = np.array([width[name] for name in told.names]) ** -2.0
    found = np.linalg.solve(told.normal + np.diag(precision), told.right + means * precision)
    expected = np.array([value[name] for name in told.names])
    # The solver stops a thousandth of a standard uncertainty before the end.
    spread = np.sqrt(np.diag(np.linalg.inv(told.normal + np.diag(precision))))
    assert np.abs(found - expected).max() / spread.max() < 2e-3
    assert np.all(np.abs(found - expected) < 2e-3 * spread)


def test_what_concerns_the_set_up_is_integrated_out(campaign):
    told = information_of(campaign)

    assert not {name for name in told.names if name.startswith(("base_", "frame_", "fixed_"))}
    assert {"c_2", "gap_4", "wave_6_100_sin", "scale"} <= set(told.names)
    assert np.linalg.eigvalsh(told.normal / np.sqrt(np.outer(*2 * [np.diag(told.normal)]))).min() > -1e-9


def test_one_robot_is_no_fleet(campaign):
    told = information_of(campaign, ("base", "geometry"))

    with pytest.raises(ConfigurationError, match="at least two robots"):
        fleet_of([FleetCampaign("A", "tracker", day, told) for day in (0.0, 30.0)])
