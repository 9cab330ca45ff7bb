"""Every registered effect: well-formed parameters, terms that are its own, and what it chooses them from."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.domain.campaign import Stops
from truepose.domain.errors import UnknownEffectError
from truepose.domain.identification import Unit
from truepose.effects.arm.compliance import compliance_prior
from truepose.effects.arm.geometry import is_parallel_to_previous
from truepose.effects.names import joint_name, joint_of, nest_name, nest_port_index
from truepose.effects.ports import PortKind, Rows, Setting, known_frames
from truepose.effects.registry import EFFECTS, effect_named
from truepose.kinematics.chain import nominal_chain

UNITS = set(get_args(Unit))


def setting(robot=IRB_120, **changes):
    values = {
        "robot": robot,
        "unknown_nests": (1, 3),
        "has_orientations": True,
        "torque_source": "masses",
        "largest_torque_n_mm": np.full(robot.n_joints, 1e4),
    }
    return Setting(**(values | changes))


def rows(robot):
    joints = np.random.default_rng(0).uniform(-1.0, 1.0, (4, robot.n_joints))
    return Rows(
        stops=Stops(np.arange(4), joints),
        nest=np.array([1, 3, 1, 3]),
        torque_n_mm=1e3 * joints,
        turn_rad=joints * [row.sign for row in robot.joints],
        frames=known_frames(nominal_chain(robot, joints)),
        gravity_m_s2=np.array([0.0, 0.0, -9.81]),
        robot=robot,
    )


def shortened(n_joints):
    """The IRB 120 cut off after some joints."""
    return replace(
        IRB_120,
        joints=IRB_120.joints[:n_joints],
        masses=tuple(mass for mass in IRB_120.masses if mass.frame <= n_joints),
        typical_compliances_rad_per_n_mm=None,
    )


SETTINGS = {
    "six axes": setting(),
    "seven axes": setting(SEVEN_AXES),
    "masses unknown": setting(torque_source="unknown", largest_torque_n_mm=np.zeros(6)),
    "on a wall": setting(
        torque_source="unknown", largest_torque_n_mm=np.zeros(6), gravity_m_s2=(9.81, 0.0, 0.0)
    ),
    "five axes": setting(shortened(5)),
    "one axis": setting(shortened(1)),
}


@pytest.mark.parametrize("name", EFFECTS)
@pytest.mark.parametrize("where", SETTINGS)
def test_every_parameter_is_well_formed_and_acts_and_terms_belong_to_the_parameters_given(name, where):
    chosen = SETTINGS[where]
    specs = EFFECTS[name].specs(chosen)
    names = tuple(spec.name for spec in specs)

    terms = EFFECTS[name].terms(names, rows(chosen.robot))

    assert len(set(names)) == len(names)
    assert all(spec.unit in UNITS for spec in specs)
    assert all(np.isfinite(spec.prior_mean) and 0.0 < spec.prior_width < np.inf for spec in specs)
    assert {term.parameter for term in terms} == set(range(len(names)))
    assert all(np.ndim(term.weight) == 0 or np.shape(term.weight) == (4,) for term in terms)
    joints = {PortKind.ALPHA, PortKind.A, PortKind.BETA, PortKind.THETA, PortKind.D}
    assert all(0 <= term.port.number < chosen.robot.n_joints for term in terms if term.port.kind in joints)


@pytest.mark.parametrize("name", EFFECTS)
def test_some_of_the_parameters_alone_act_as_among_all(name):
    """Terms are asked for by name: a part of the names gives that part of the terms."""
    names = tuple(spec.name for spec in EFFECTS[name].specs(setting()))
    everything = EFFECTS[name].terms(names, rows(IRB_120))

    last = EFFECTS[name].terms(names[-1:], rows(IRB_120))

    wanted = [term for term in everything if term.parameter == len(names) - 1]
    assert [term.port for term in last] == [term.port for term in wanted]
    assert all(np.array_equal(a.weight, b.weight) for a, b in zip(last, wanted, strict=True))


def test_names_lead_back_to_what_they_name():
    assert joint_name("alpha", 2) == "alpha_3"
    assert [joint_of(joint_name("theta", joint)) for joint in range(12)] == list(range(12))
    assert nest_name(2, 0) == "nest_2_x"
    assert [nest_port_index(nest_name(nest, axis)) for nest in (1, 12) for axis in range(3)] == [
        0, 1, 2, 33, 34, 35,
    ]  # fmt: skip


def test_an_unknown_effect_is_refused_with_the_known_ones():
    with pytest.raises(
        UnknownEffectError, match=r"Unknown effect 'magic'; available effects: base, tool, geometry"
    ):
        effect_named("magic")


def test_near_parallel_axes_are_found_from_the_table():
    assert [is_parallel_to_previous(IRB_120, joint) for joint in range(6)] == [False, False, True] + 3 * [
        False
    ]
    antiparallel = replace(IRB_120.joints[2], alpha_rad=np.pi)
    robot = replace(IRB_120, joints=(*IRB_120.joints[:2], antiparallel, *IRB_120.joints[3:]))
    assert is_parallel_to_previous(robot, 2)


def test_only_the_tilt_tells_geometry_from_plain_dh_modified():
    full = {spec.name for spec in EFFECTS["geometry"].specs(setting())}
    plain = {spec.name for spec in EFFECTS["geometry_dhm"].specs(setting())}

    assert full - plain == {"beta_3"}
    assert plain < full


def test_the_prior_of_a_spring_is_the_typical_one_where_the_maker_gives_it():
    means, widths = compliance_prior(setting())

    assert means.tolist() == widths.tolist() == list(IRB_120.typical_compliances_rad_per_n_mm)


def test_without_typical_springs_no_gearbox_yields_more_than_a_hundredth_of_a_radian():
    robot = replace(IRB_120, typical_compliances_rad_per_n_mm=None)
    torque = np.array([0.0, 1e6, 1e5, 1e4, 1e2, 1.0])

    means, widths = compliance_prior(setting(robot, largest_torque_n_mm=torque))

    assert not means.any()
    assert np.all(widths * torque <= 0.01 * (1.0 + 1e-12))
    assert widths[1] == pytest.approx(1e-8)
    assert widths[5] == pytest.approx(2e-6)  # a light joint: no gearbox is softer than that


@pytest.mark.parametrize(
    ("gravity_m_s2", "first"),
    [((0.0, 0.0, -9.81), 2), ((0.0, 0.0, 9.81), 2), ((0.1, 0.0, -9.81), 2), ((9.81, 0.0, 0.0), 1)],
)
def test_joint_1_has_products_unless_the_arm_stands_upright_or_hangs(gravity_m_s2, first):
    chosen = setting(torque_source="unknown", largest_torque_n_mm=np.zeros(6), gravity_m_s2=gravity_m_s2)
    compliance = EFFECTS["compliance"]

    names = [spec.name for spec in compliance.specs(chosen)]
    (left_open,) = compliance.left_open(tuple(names), chosen)

    assert names[0] == f"c_{first}*mx_{first}"
    assert left_open.parameters == tuple(f"c_{joint}" for joint in range(first, 7))


@pytest.mark.parametrize(
    ("gravity_m_s2", "key"),
    [((0.0, 0.0, -9.81), "open.spring_upright"), ((9.81, 0.0, 0.0), "open.spring_idle")],
)
def test_only_an_upright_joint_1_is_idle_because_it_is_upright(gravity_m_s2, key):
    chosen = setting(largest_torque_n_mm=np.zeros(6), gravity_m_s2=gravity_m_s2)

    first, second, *_ = EFFECTS["compliance"].left_open((), chosen)

    assert first.reason.key == key
    assert second.reason.key == "open.spring_idle"


def test_a_joint_that_carries_no_torque_has_no_spring():
    torque = np.array([0.0, 1e4, 1e4, 1e4, 1e4, 1.0])

    names = [spec.name for spec in EFFECTS["compliance"].specs(setting(largest_torque_n_mm=torque))]

    assert names == ["c_2", "c_3", "c_4", "c_5"]
