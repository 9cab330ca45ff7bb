"""By how much the campaigns of each robot scatter more than their readings say."""

import numpy as np
import pytest

from tests.helpers.fleet.linear import SCALE, told
from truepose.effects.ports import ParameterSpec
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.mixed_model import Equations, estimate
from truepose.fleet.outlying_campaigns import birge_ratios

_SPECS = (*(ParameterSpec(f"d_{number}", "mm", 0.0, 1.0) for number in range(20)), SCALE)


def _ratios(scatter, ages=0.0):
    """Return the ratios of six robots in six months, of which the second scatters and the fifth ages."""
    rng = np.random.default_rng(7)
    campaigns = []
    for robot in range(6):
        own = 0.3 * rng.standard_normal(20)
        for month in range(6):
            unit = 3.0 * rng.standard_normal((21, 40))
            at = own + (robot == 1) * scatter * rng.standard_normal(20)
            at[3] += (robot == 4) * ages * month
            read = np.append(at, 0.0) @ unit + rng.standard_normal(40)
            jacobian = unit / np.array([spec.prior_width for spec in _SPECS])[:, None]
            campaigns.append(
                FleetCampaign(f"robot {robot}", "tracker", float(month), told(jacobian, read, _SPECS))
            )
    return birge_ratios(estimate(Equations(fleet_of(campaigns))).posterior)


def test_a_robot_that_scatters_has_its_own_ratio_and_the_others_have_that_of_the_middle_one():
    ratios = _ratios(scatter=0.1)

    others = np.delete(ratios, 1)
    assert others == pytest.approx(1.0, abs=0.25)  # a hundred degrees of freedom a robot: to 14 %
    assert ratios[1] > 2.0


def test_a_robot_that_ages_in_one_cause_scatters_by_little():
    ratios = _ratios(scatter=0.0, ages=0.1)

    assert ratios[4] < 2.0  # ten standard uncertainties at the end, in one of twenty parameters
