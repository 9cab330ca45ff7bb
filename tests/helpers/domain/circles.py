"""Readings of circle tests: of arms that are known, and those that were measured."""

import csv

import numpy as np

from truepose.domain.campaign import PointReadings, Stops
from truepose.kinematics.chain import nominal_chain

NEST_MM = (-114.4, -46.2, 124.5)  # thesis of A. Nubiola, 2014, section 2.4.1
MEASURED_SCATTER_MM = 0.02  # per axis: distances between the reflectors scatter by 0.03 mm


def there_and_back(low_deg, high_deg, step_deg):
    """Angles of one joint in degrees, in both directions."""
    up = np.arange(low_deg, high_deg + 0.5 * step_deg, step_deg)
    return np.concatenate([up, up[-2::-1]])


def turned(joint, angles_deg, n_joints=6):
    """Configurations in which one joint is turned [rad]."""
    joints = np.zeros((len(angles_deg), n_joints))
    joints[:, joint - 1] = np.radians(angles_deg)
    return joints


def points_of(joints_rad, places_mm, u_mm=0.01, nest=1, **known):
    """A table of points."""
    n = len(joints_rad)
    stops = Stops(np.arange(1, n + 1), np.asarray(joints_rad), **known)
    return PointReadings(stops, np.broadcast_to(nest, n), np.asarray(places_mm), np.full(n, u_mm))


def read_on(robot, joints_rad, *, true_rad=None, scatter_mm=0.0, u_mm=0.01, seed=1, **known):
    """What is read of a nest on a robot whose joints truly stand at `true_rad`."""
    stands = joints_rad if true_rad is None else true_rad
    places = nominal_chain(robot, stands).points(np.tile(NEST_MM, (len(stands), 1)))
    noise = scatter_mm * np.random.default_rng(seed).standard_normal(places.shape)
    return points_of(joints_rad, places + noise, u_mm, **known)


def measured_circles(folder):
    """The 36 poses of the example data at all three reflectors; the display counts joint 3 from level."""
    with (folder / "single-axis-circles" / "poses.csv").open(encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    joints = np.radians([[row[f"q{k}_deg"] for k in range(1, 7)] for row in rows])
    joints[:, 2] += joints[:, 1]
    places = [[row[f"smr{nest}_{axis}_mm"] for axis in "xyz"] for nest in (1, 2, 3) for row in rows]
    nest = np.repeat((1, 2, 3), len(rows))
    return points_of(np.tile(joints, (3, 1)), places, MEASURED_SCATTER_MM, nest)
