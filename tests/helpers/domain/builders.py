"""Domain objects with dull defaults; a test names only what it is about."""

import math

import numpy as np

from truepose.domain.campaign import (
    NO_AXIS,
    Campaign,
    ContactReadings,
    CupReadings,
    CupSetups,
    FixedNestReadings,
    FixtureLengths,
    LegReadings,
    PointReadings,
    Stops,
    TargetDistances,
)
from truepose.domain.contacts import Target, TargetKind
from truepose.domain.identification import (
    Counts,
    Identification,
    Model,
    NestCentre,
    NominalAndIdentified,
    Parameter,
    Statistics,
    Status,
)
from truepose.domain.robot import FixedNest, FramePlacement, JointRow, LinkMass, Nest, Robot

ELBOW = (
    JointRow(0.0, 0.0, 0.0, 300.0),
    JointRow(-math.pi / 2, 50.0, 0.0, 0.0),
    JointRow(0.0, 400.0, 0.0, 0.0),
)


def make_robot(**changes):
    """A robot of three joints with one mass."""
    values = {
        "name": "elbow",
        "joints": ELBOW,
        "masses": (LinkMass(3, 2.0, (100.0, 0.0, 5.0)),),
        "repeatability_mm": 0.01,
    }
    return Robot(**{**values, **changes})


def make_stops(n=3, n_joints=3, **changes):
    """Configurations 1..n, every joint turned a little further each time."""
    values = {
        "config": np.arange(1, n + 1),
        "joints_rad": np.radians(np.arange(n * n_joints).reshape(n, n_joints) * 1.5 - 10.0),
    }
    return Stops(**{**values, **changes})


def make_points(n=3, n_joints=3, stops=None, **changes):
    """Positions of nest 1 along a line, 0.02 mm each."""
    values = {
        "stops": make_stops(n, n_joints) if stops is None else stops,
        "nest": np.ones(n, np.int64),
        "position_mm": np.arange(3.0 * n).reshape(n, 3) * 12.5 + 100.0,
        "standard_uncertainty_mm": np.full(n, 0.02),
    }
    return PointReadings(**{**values, **changes})


def make_legs(n=3, n_joints=3, **changes):
    """Legs from base nest 1 to tool nest 1, near 300 mm."""
    values = {
        "stops": make_stops(n, n_joints),
        "placement": np.ones(n, np.int64),
        "base_point": np.ones(n, np.int64),
        "nest": np.ones(n, np.int64),
        "length_mm": 300.0 + 0.125 * np.arange(n),
        "standard_uncertainty_mm": np.full(n, 0.0005),
    }
    return LegReadings(**{**values, **changes})


def make_reference():
    """Two looks at fixed nest 1."""
    return FixedNestReadings(
        np.array([1.0, 60.5]), np.array([1, 1]), np.array([[600.0, 0.0, 0.5]] * 2), np.full(2, 0.015)
    )


def make_fixture():
    """One side of the tool triangle and one of the base."""
    return FixtureLengths(
        np.array([0, 1]), np.array([1, 1]), np.array([2, 3]), np.array([150.25, 300.5]), np.full(2, 0.0005)
    )


def make_setup(n_joints=3):
    """Cup 2 of placement 1."""
    return CupSetups(np.array([1]), np.array([2]), np.radians(np.full((1, n_joints), 12.25)))


def make_cups():
    """Cup 2 of placement 1, seen by the tracker."""
    return CupReadings(np.array([1]), np.array([2]), np.array([[210.5, -126.25, -15.125]]), np.array([0.005]))


def make_campaign(**changes):
    """A tracker campaign of three configurations with one known nest."""
    values = {
        "robot": make_robot(),
        "base_nominal": FramePlacement(),
        "nests": (Nest((0.0, 0.0, 100.0), 0.002),),
        "calibration": make_points(),
    }
    return Campaign(**{**values, **changes})


def make_ballbar_campaign(**changes):
    """A campaign with every table of the ballbar and the tracker's judgement of it."""
    values = {
        "calibration": None,
        "legs": make_legs(),
        "validation_legs": make_legs(2),
        "validation": make_points(),
        "fixture": make_fixture(),
        "setup": make_setup(),
        "cups": make_cups(),
        "reference": make_reference(),
        "fixed_nests": (FixedNest((600.0, 0.0, 0.5), 0.002),),
        "ballbar_nominal_mm": 300.0,
        "ballbar_range_mm": 1.0,
        "setup_uncertainty_mm": 0.01,
    }
    return make_campaign(**{**values, **changes})


def make_targets():
    """A sphere about which much is known, and a gauge about which nothing is."""
    sphere = Target(1, TargetKind.SPHERE, 25.5, 0.001, 0.0005, place_mm=(400.0, -100.5, 50.25))
    return sphere, Target(3, TargetKind.GAUGE), Target(7, TargetKind.BALL, place_mm=(1.0, 2.0, 3.0))


def make_contacts(n=3, n_joints=3, **changes):
    """Readings about 0 against the targets of `make_targets` by turns."""
    target = np.array([1, 3, 7])[np.arange(n) % 3]
    values = {
        "stops": make_stops(n, n_joints),
        "target": target,
        "nest": np.ones(n, np.int64),
        "reading_mm": 0.125 * np.arange(n) - 0.25,
        "standard_uncertainty_mm": np.full(n, 0.002),
        "axis": np.where(target == 7, 2, NO_AXIS),
    }
    return ContactReadings(**{**values, **changes})


def make_contact_campaign(**changes):
    """A closed loop with every table that it may have."""
    distances = TargetDistances(np.array([1]), np.array([7]), np.array([300.125]), np.array([0.001]))
    values = {
        "calibration": None,
        "contacts": make_contacts(6),
        "validation_contacts": make_contacts(),
        "targets": make_targets(),
        "target_distances": distances,
    }
    return make_campaign(**{**values, **changes})


def make_parameter(**changes):
    """An angle of 1 mrad, known to 0.1 mrad."""
    values = {
        "name": "alpha_2",
        "effect": "geometry",
        "value": 1e-3,
        "unit": "rad",
        "standard_uncertainty": 1e-4,
        "prior_width": 5e-3,
    }
    return Parameter(**{**values, **changes})


def make_model(**changes):
    """A model with one angle and one length, correlated."""
    values = {
        "robot": make_robot(),
        "base": FramePlacement(x_mm=1.0, rz_rad=0.3),
        "nests": (NestCentre(1, (0.1, 0.2, 100.0)),),
        "tool_rotation_rad": (0.1, -0.2, 0.3),
        "effects": ("base", "geometry"),
        "parameters": (
            make_parameter(),
            make_parameter(name="a_3", value=0.2, unit="mm", standard_uncertainty=0.01, prior_width=1.0),
        ),
        "covariance": np.array([[1e-8, 5e-7], [5e-7, 1e-4]]),
        "gravity_m_s2": (0.0, 0.0, -9.81),
        "discrepancy_mm": 0.05,
        "repeatability_mm": 0.01,
        "nominal_base": FramePlacement(y_mm=2.0, rx_rad=0.01),
        "nominal_nests": (NestCentre(1, (0.0, 0.0, 100.0)),),
        "identified_from": {"campaign": "elbow", "configurations": 3},
        "program_version": "0.1.0",
    }
    return Model(**{**values, **changes})


def make_statistics(**changes):
    """Ten errors of about a tenth of a millimetre."""
    values = {"n": 10, "mean_mm": 0.1, "rms_mm": 0.11, "sd_mm": 0.02, "max_mm": 0.2, "noise_mm": 0.03}
    return Statistics(**{**values, **changes})


def make_pair(**changes):
    """The same statistics for nominal and identified."""
    return NominalAndIdentified(make_statistics(), make_statistics(**changes))


def make_identification(**changes):
    """A converged identification of points without a validation file."""
    values = {
        "status": Status.CONVERGED,
        "message": "The identification converged.",
        "effects": ("base", "geometry"),
        "counts": Counts(configurations=3, observations=9, parameters=2, outliers=0),
        "parameters": make_model().parameters,
        "not_identifiable": (),
        "outliers": (),
        "quantity": "position",
        "calibration": make_pair(),
        "validation": None,
        "cross_validation": make_pair(),
        "calibration_without_outliers": None,
        "chi2_per_dof": 1.02,
        "pure_error": None,
        "model": make_model(),
    }
    return Identification(**{**values, **changes})
