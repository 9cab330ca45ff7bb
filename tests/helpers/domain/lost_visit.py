"""A test of ISO 9283 from which a visit was lost, and the model that it is a test of."""

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement
from truepose.identification.model.validity import measured_zone
from truepose.kinematics.chain import nominal_chain
from truepose.validation.iso9283.plan import Cube, plan_poses

_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))
MODEL = model_of(
    IRB_120,
    nominal_base=FramePlacement(x_mm=1.0),
    zone=measured_zone(IRB_120, configurations(50)),
    discrepancy_mm=0.03,
    base=FramePlacement(),
    nests=_CENTRES,
    nominal_nests=_CENTRES,
)


def planned_poses(robot=IRB_120, nest_mm=NESTS[0]):
    return plan_poses(robot, Cube((300.0, 0.0, 250.0), 150.0), np.diag([1.0, -1.0, -1.0]), nest_mm)


def cycle_stops(poses, lost, others_rad):
    """Thirty cycles of the poses but for the stop `lost`, and other configurations after them."""
    stops = [stop for stop in poses.session(nest=1).stops if stop.config != lost]
    config = [*(stop.config for stop in stops), *range(201, 201 + len(others_rad))]
    repeat_of = [-1 if stop.repeat_of is None else stop.repeat_of for stop in stops]
    return Stops(
        np.array(config),
        np.vstack([[stop.joints_rad for stop in stops], others_rad]),
        repeat_of=np.array(repeat_of + [-1] * len(others_rad)),
    )


def readings_of_model(scatter_mm=0.0):
    """What is read of `MODEL`, which is 0.05 mm wrong: P3 was missed once."""
    stops = cycle_stops(planned_poses(), 13, configurations(20, seed=4))
    places = nominal_chain(IRB_120, stops.joints_rad).points(np.array(NESTS[0]))
    scatter = scatter_mm * np.random.default_rng(5).standard_normal(places.shape)
    seen = places + np.array([0.03, 0.0, 0.04]) + scatter
    n = len(stops)
    return PointReadings(stops, np.ones(n, dtype=np.int64), seen, np.full(n, 0.002))
