"""A robot of three joints with small errors, measured by a tracker of 0.01 mm, and its identification."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_model, make_robot
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.robot import Nest, WorldRegistration
from truepose.identification import identify, predict

TRACKER_MM = 0.01


def stops_at_random(generator, n, first_config=1):
    joints = generator.uniform(-1.2, 1.2, (n, 3))
    return Stops(config=np.arange(first_config, first_config + n), joints_rad=joints)


def measured(generator, stops):
    """Positions of the true arm, which is `make_model()`, as a tracker sees them."""
    nest = np.ones(len(stops), np.int64)
    position, _ = predict(make_model(), stops, nest)
    noise = generator.normal(0.0, TRACKER_MM, position.shape)
    return PointReadings(stops, nest, position + noise, np.full(len(stops), TRACKER_MM))


@pytest.fixture(scope="session")
def campaign():
    generator = np.random.default_rng(7)
    return make_campaign(
        robot=make_robot(masses=(), repeatability_mm=0.0),
        base_nominal=make_model().base,
        nests=(Nest(make_model().nests[0].centre_mm, 0.002),),
        calibration=measured(generator, stops_at_random(generator, 40)),
        validation=measured(generator, stops_at_random(generator, 60, first_config=101)),
        registration=WorldRegistration(np.diag([1e-5, 1e-5, 1e-5, 1e-11, 1e-11, 1e-11])),
    )


@pytest.fixture(scope="session")
def identification(campaign):
    return identify(campaign, ("base", "geometry"))


@pytest.fixture(scope="session")
def campaign_without_validation(campaign):
    return replace(campaign, validation=None)
