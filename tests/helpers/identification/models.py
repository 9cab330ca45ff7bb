"""Models with parameters of every effect, as an identification or a diagnosis would write them."""

from collections import defaultdict
from dataclasses import replace

import numpy as np

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.domain.campaign import Stops
from truepose.domain.identification import Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement, LinkMass

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
ORIGIN_S = 500.0
INSTRUMENT_MM = (2600.0, -700.0, 500.0)
LOADED_SEVEN_AXES = replace(
    SEVEN_AXES,
    masses=(
        LinkMass(2, 4.0, (10.0, 50.0, 20.0)),
        LinkMass(3, 2.0, (5.0, -20.0, 100.0)),
        LinkMass(4, 3.0, (0.0, -30.0, 10.0)),
        LinkMass(7, 1.0, (0.0, 20.0, 50.0)),
    ),
)
ROBOTS = {"irb120": IRB_120, "seven-axes": LOADED_SEVEN_AXES}


def _motion(prefix, shift, turn, units=("mm", "rad")):
    """Six parameters of different sizes: nothing cancels."""
    sizes = (1.0, -0.7, 0.4, 0.6, -1.0, 0.8)
    return [
        (f"{prefix}_{name}", size * (shift if k < 3 else turn), units[k // 3])
        for k, (name, size) in enumerate(zip(COMPONENTS, sizes, strict=True))
    ]


_PER_H = ("mm/h", "rad/h")
# Realistic sizes of issue and thesis, some larger: each moves the tool by a tenth of a millimetre or more.
EXTENSIONS = {
    "axis_parallelism": [("beta_3", 3e-4, "rad")],
    "backlash": [("gap_2", 5e-4, "rad"), ("gap_5", 3e-4, "rad"), ("gap_6", 6e-4, "rad")],
    "base_compliance": [("base_c", 5e-9, "rad/(N*mm)")],
    "base_drift": _motion("drift_linear", 0.1, 1e-4, _PER_H) + _motion("drift_exp600", 0.3, 3e-4, _PER_H),
    "base_shift": _motion("jump_1234.5", 0.1, 1e-4) + _motion("jump_2500", 0.05, -1e-4),
    "compliance_nonlinear": [("soft_2_2000", 3e-8, "rad/(N*mm)"), ("soft_5_500", 3e-7, "rad/(N*mm)")],
    "instrument_drift": _motion("tracker_linear", 0.1, 1e-4, _PER_H)
    + _motion("tracker_exp1200", 0.2, 1e-4, _PER_H),
    "instrument_scale": [("scale", 1e-4, "1")],
    "joint_coupling": [("coupling_6_5", 5e-4, "1"), ("coupling_5_2", -3e-4, "1")],
    "joint_gain": [("gain_2", 2e-4, "1"), ("gain_5", -4e-4, "1")],
    "joint_harmonics": [
        ("wave_2_1_sin", 1e-4, "rad"),
        ("wave_2_1_cos", -8e-5, "rad"),
        ("wave_5_2_cos", 3e-4, "rad"),
        ("wave_6_101_sin", 3e-4, "rad"),
        ("wave_3_2.5_cos", 1e-4, "rad"),
    ],
    "link_bending": [("sag_2", 2e-11, "1/(N*mm2)")],
    "link_mass": [
        ("mass_4", 0.5, "kg"),
        ("moment_4_x", 60.0, "kg*mm"),
        ("mass_2", -0.5, "kg"),
        ("moment_2_z", 50.0, "kg*mm"),
    ],
    "nest_offset": [("offset_2_x", 0.06, "mm"), ("offset_2_y", -0.04, "mm"), ("offset_2_z", 0.05, "mm")],
    "payload": [
        ("payload_mass", 0.3, "kg"),
        ("payload_x", 20.0, "kg*mm"),
        ("payload_y", -15.0, "kg*mm"),
        ("payload_z", 30.0, "kg*mm"),
    ],
    "thermal_growth": [("growth", 18e-6, "1/K")],
    "tool_certificate": [("certified_1_x", 0.05, "mm"), ("certified_2_z", -0.04, "mm")],
    "tool_reseating": _motion("seat_1", 0.03, 3e-4) + _motion("seat_2", -0.05, 2e-4),
}


def parameters_of(effect, stated):
    return tuple(Parameter(name, effect, float(value), unit, 0.0, 1.0) for name, value, unit in stated)


def plain_parameters(robot, seed=1):
    """Base, tool, every row of the table and every spring, each off by a believable amount."""
    rng = np.random.default_rng(seed)
    rows = range(2, robot.n_joints + 1)
    kinds = (("alpha", 1e-3, "rad"), ("a", 0.3, "mm"), ("theta", 2e-3, "rad"), ("d", 0.3, "mm"))
    geometry = [
        (f"{kind}_{row}", size * rng.standard_normal(), unit) for row in rows for kind, size, unit in kinds
    ]
    springs = [(f"c_{j}", rng.uniform(1e-8, 5e-7), "rad/(N*mm)") for j in range(1, robot.n_joints + 1)]
    return (
        *parameters_of("base", _motion("base", 1.5, 3e-3)),
        *parameters_of("tool", [("nest_1_x", 0.3, "mm"), ("nest_1_z", -0.2, "mm")]),
        *parameters_of("geometry", geometry),
        *parameters_of("compliance", springs),
    )


def model_of(robot=IRB_120, *parameters, **changes):
    """A robot that stands askew, under gravity that is not plumb, with these parameters."""
    values = {
        "robot": robot,
        "base": FramePlacement(100.0, -50.0, 30.0, 0.2, -0.3, 2.9),
        "nests": (NestCentre(1, (0.0, 0.0, 125.0)), NestCentre(2, (75.0, 93.7, 215.0))),
        "tool_rotation_rad": (0.0, 0.0, 0.0),
        "effects": tuple(dict.fromkeys(parameter.effect for parameter in parameters)),
        "parameters": tuple(parameters),
        "covariance": np.zeros((len(parameters), len(parameters))),
        "gravity_m_s2": (1.0, -2.0, -9.5),
        "discrepancy_mm": 0.0,
        "repeatability_mm": 0.01,
        "nominal_base": FramePlacement(),
        "nominal_nests": (NestCentre(1, (0.0, 0.0, 125.0)), NestCentre(2, (75.0, 93.7, 215.0))),
        "instrument_mm": INSTRUMENT_MM,
        "origin_s": ORIGIN_S,
    }
    return Model(**(values | changes))


def extended(robot, *effects):
    """The plain model and these effects."""
    by_effect = defaultdict(tuple, {e: parameters_of(e, EXTENSIONS[e]) for e in effects})
    extra = (parameter for effect in effects for parameter in by_effect[effect])
    return model_of(robot, *plain_parameters(robot), *extra)


def stops_and_nests(robot, n=60, seed=2):
    """Stops of the campaign, with everything that effects may depend on."""
    rng = np.random.default_rng(seed)
    shape = (n, robot.n_joints)
    stops = Stops(
        config=np.arange(1, n + 1),
        joints_rad=np.radians(np.degrees(rng.uniform(-2.5, 2.5, shape)).round(5)),
        direction=rng.choice([-1, 0, 1], shape),
        time_s=np.linspace(ORIGIN_S, 4000.0, n).round(1),
        temperature_c=rng.uniform(18.0, 30.0, n).round(2),
        attachment=rng.integers(1, 4, n),
    )
    return stops, rng.integers(1, 3, n)


def registered(model):
    """A model as of a real arm: the nominal robot stands at its base, and errors are below 5 mm."""
    smaller = tuple(replace(one, value=0.4 * one.value) for one in model.parameters)
    return replace(model, parameters=smaller, nominal_base=model.base)
