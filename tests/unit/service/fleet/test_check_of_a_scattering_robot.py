"""A check of a robot that scatters more than the others."""

import numpy as np

from tests.helpers.fleet.linear import SCALE, told
from truepose.effects.ports import ParameterSpec
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.changes import account_of
from truepose.fleet.interim_check import grown

_SPECS = (
    *(ParameterSpec(f"d_{number}", "mm", 0.0, 1.0) for number in range(19)),
    ParameterSpec("c_3", "rad/(N*mm)", 0.0, 1.0),
    SCALE,
)
_OWNERS = (*["geometry"] * 19, "compliance", "instrument_scale")
_SCATTER = 0.3  # of each parameter from one campaign to the next: six standard uncertainties


def _told(rng, own, scatter):
    unit = 3.0 * rng.standard_normal((21, 40))
    at = np.append(own + scatter * rng.standard_normal(20), 0.0)
    jacobian = unit / np.array([spec.prior_width for spec in _SPECS])[:, None]
    return told(jacobian, at @ unit + rng.standard_normal(40), _SPECS, _OWNERS)


def test_checks_of_a_robot_that_scatters_in_which_nothing_has_grown_tell_nothing():
    rng = np.random.default_rng(7)
    robots = 0.3 * rng.standard_normal((6, 20))
    scatter = np.where(np.arange(6) == 1, _SCATTER, 0.0)
    account = account_of(
        fleet_of([
            FleetCampaign(f"robot {number}", "tracker", float(month), _told(rng, own, scatter[number]))
            for number, own in enumerate(robots)
            for month in range(6)
        ])
    )

    checks = [grown(account, "robot 1", _told(rng, robots[1], _SCATTER), 0.5) for _ in range(40)]

    assert account.birge_ratios[1] > 10.0 * account.birge_ratio
    false = sum(one.is_told for check in checks for one in check)
    assert false <= 6  # of forty at 5 %: chance has more than six once in thirty
