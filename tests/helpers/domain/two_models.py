"""Two models of one robot, and what an instrument sees of it."""

from dataclasses import replace

import numpy as np

from tests.helpers.domain.builders import make_model
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification import predict


def with_values(*values, **changes):
    model = make_model(**changes)
    parameters = [replace(one, value=v) for one, v in zip(model.parameters, values, strict=True)]
    return replace(model, parameters=tuple(parameters))


def seen_by(model, n=12):
    """Readings without noise of an arm that is `model`."""
    joints = np.random.default_rng(2).uniform(-1.2, 1.2, (n, 3))
    stops = Stops(config=np.arange(1, n + 1), joints_rad=joints)
    nest = np.ones(n, np.int64)
    return PointReadings(stops, nest, predict(model, stops, nest)[0], np.full(n, 0.01))
