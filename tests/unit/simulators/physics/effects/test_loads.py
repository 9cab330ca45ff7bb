import numpy as np
import pytest

from truepose_simulators.physics.arm import CarriedMass
from truepose_simulators.physics.effects.link_bending import Beam, bending, sag_mm
from truepose_simulators.physics.loads import place_masses

from .conftest import ARM, SPRINGS, TOOL

# upper arm laid down by 90 deg, forearm brought level: everything points forward
STRETCHED_DEG = [0.0, 90.0, -90.0, 0.0, 0.0, 0.0]
POSES_DEG = np.random.default_rng(5).uniform(-70, 70, (10, 6))


def test_an_extra_spring_winds_up_by_its_own_share_of_the_torque(bench, at):
    spring = bench.effect("compliance", "joint 2", 1e-8)
    stops = at(POSES_DEG)

    rest = bench.rest(stops, spring)

    wound = rest.angles_rad - stops.joints_rad - SPRINGS * rest.torque_n_mm
    # The loop ends when torques repeat to 1e-4 N mm.
    assert wound[:, 1] == pytest.approx(1e-8 * rest.torque_n_mm[:, 1], abs=1e-11)
    assert np.abs(wound[:, 2:]).max() < 1e-10


def test_a_gear_is_softer_unloaded_and_as_stiff_as_ever_under_load(bench, at):
    soft = bench.effect("compliance_nonlinear", "joint 2", 0.5, t0_n_mm=2000.0)
    leaning = np.zeros((2, 6))
    leaning[:, 1] = 60.0, -32.0  # joint 2 carries much, then next to nothing
    stops = at(leaning)

    rest = bench.rest(stops, soft)
    extra = (rest.angles_rad - stops.joints_rad - SPRINGS * rest.torque_n_mm)[:, 1]

    loaded, unloaded = rest.torque_n_mm[:, 1]
    assert loaded > 20_000.0
    assert abs(unloaded) < 1000.0
    # Far beyond t0 all that comes on top is the constant share * c * t0 ...
    assert extra[0] == pytest.approx(0.5 * SPRINGS[1] * 2000.0, rel=1e-6)
    # ... and near zero torque the spring is softer by the share: tanh x = x within x^2 / 3.
    assert extra[1] == pytest.approx(0.5 * SPRINGS[1] * unloaded, rel=(unloaded / 2000.0) ** 2 / 3)


def test_all_gears_may_be_softer_at_once(bench, at):
    stops = at(POSES_DEG)
    together = bench.effect("compliance_nonlinear", "joints", 0.3)
    singly = [bench.effect("compliance_nonlinear", f"joint {joint}", 0.3) for joint in range(1, 7)]

    assert bench.rest(stops, together).angles_rad == pytest.approx(
        bench.rest(stops, *singly).angles_rad, abs=1e-12
    )


def test_a_heavier_tool_adds_its_weight_times_its_lever_to_the_torque(rigid_bench, at):
    heavier = rigid_bench.effect("payload", "tool", 1.0)
    stops = at(STRETCHED_DEG)

    extra = (rigid_bench.rest(stops, heavier).torque_n_mm - rigid_bench.rest(stops).torque_n_mm)[0]

    # Stretched, joint 2 is the upper arm (270), the forearm (302), the flange (72) and the centre of
    # gravity (100 along the flange) away; joint 5 the last two.
    assert extra[1] == pytest.approx(9.81 * (270 + 302 + 72 + 100), rel=1e-9)
    assert extra[4] == pytest.approx(9.81 * (72 + 100), rel=1e-9)


def test_a_shifted_centre_of_gravity_acts_with_the_whole_mass(rigid_bench, at):
    shifted = rigid_bench.effect("payload", "tool", 0.0, centre_shift_mm=[0.0, 0.0, 10.0])
    stops = at(STRETCHED_DEG)

    extra = (rigid_bench.rest(stops, shifted).torque_n_mm - rigid_bench.rest(stops).torque_n_mm)[0]

    assert extra[[1, 4]] == pytest.approx([2.7 * 9.81 * 10.0] * 2, rel=1e-9)


def test_a_heavier_link_is_felt_by_the_joints_below_it_only(rigid_bench, at):
    heavier = rigid_bench.effect("link_mass", "link 4", 0.5)
    stops = at(STRETCHED_DEG)

    extra = (rigid_bench.rest(stops, heavier).torque_n_mm - rigid_bench.rest(stops).torque_n_mm)[0]

    # Its centre of gravity is 108.4 in front of the elbow.
    assert extra[1] == pytest.approx(0.5 * 9.81 * (270 + 108.4), rel=1e-9)
    assert extra[2] == pytest.approx(0.5 * 9.81 * 108.4, rel=1e-9)
    assert extra[[0, 3, 4, 5]] == pytest.approx([0.0] * 4, abs=1e-9)


def test_wrong_masses_hold_from_their_time_on(rigid_bench, at):
    stops = at([STRETCHED_DEG] * 2, time_s=np.array([99.0, 100.0]))
    effects = [
        rigid_bench.effect("payload", "tool", 0.5, from_s=100.0),
        rigid_bench.effect("link_mass", "links", 0.5, from_s=100.0),
    ]

    extra = rigid_bench.rest(stops, *effects).torque_n_mm - rigid_bench.rest(stops).torque_n_mm

    assert extra[0] == pytest.approx(np.zeros(6), abs=1e-9)
    assert extra[1, 1] > 1000.0


def test_a_soft_base_gives_way_to_the_overturning_moment_towards_the_load(rigid_bench, at):
    soft = rigid_bench.effect("base_compliance", "base", 1e-9)
    ways = np.array([STRETCHED_DEG, STRETCHED_DEG])
    ways[1, 0] = 90.0

    moved = rigid_bench.moved_mm(at(ways), soft)

    # Upper arm 4.2 kg half way along 270, forearm 5 kg at 270 + 108.4, tool 2.7 kg at 744, and 25 sideways
    # or across where nothing lies below or above: the moment about the base, by hand.
    moment = 9.81 * (4.2 * 140 + 5.0 * 378.4 + 2.7 * 744)
    assert moved[0, 2] == pytest.approx(-1e-9 * moment * 644, rel=1e-3)  # sinks at the flange, 644 in front
    assert moved[0, 0] == pytest.approx(1e-9 * moment * (290 + 70), rel=1e-3)  # leans forward, 360 above
    # Turned by a quarter, the same thing happens a quarter further.
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert moved[1] == pytest.approx(turned @ moved[0], abs=1e-9)


def test_a_beam_sags_as_the_textbook_says(rigid_bench, at):
    """One weight at the end of a horizontal cantilever: F L^3 / 3 EI down, F L^2 / 2 EI turned."""
    bodies = rigid_bench.rest(at(STRETCHED_DEG)).bodies
    elbow = CarriedMass(3, 2.0, (0.0, 0.0, 560.0))  # on axis 3

    motion = bending(ARM, 2, bodies, place_masses(bodies, [elbow], None, ()))[0]

    weight = 2.0 * 9.81
    # The seat of joint 3 has x along the upper arm, z along its axis, so y points up or down.
    assert abs(motion[1]) == pytest.approx(weight * 270.0**3 / 3.0, rel=1e-9)
    assert abs(motion[5]) == pytest.approx(weight * 270.0**2 / 2.0, rel=1e-9)
    assert motion[[0, 2, 3, 4]] == pytest.approx(np.zeros(4), abs=1e-3)


def test_a_weight_beyond_the_end_bends_as_a_longer_beam_that_is_rigid_there(rigid_bench, at):
    bodies = rigid_bench.rest(at(STRETCHED_DEG)).bodies
    at_flange = CarriedMass(6, 1.0, (374.0, 0.0, 630.0))

    motion = bending(ARM, 2, bodies, place_masses(bodies, [at_flange], None, ()))[0]

    # Force at the elbow and its moment about the elbow: lever 302 + 72.
    length, lever = 270.0, 374.0
    assert abs(motion[1]) == pytest.approx(9.81 * (length**3 / 3 + lever * length**2 / 2), rel=1e-9)
    assert abs(motion[5]) == pytest.approx(9.81 * (length**2 / 2 + lever * length), rel=1e-9)


def test_a_beam_stores_the_work_of_the_weights_that_bend_it(rigid_bench, at):
    """Linear elasticity: two unit loads move each other equally (Maxwell, Betti)."""
    bodies = rigid_bench.rest(at(STRETCHED_DEG)).bodies
    near = CarriedMass(2, 1.0, (0.0, 0.0, 430.0))  # 140 along the upper arm

    end_under_near = bending(ARM, 2, bodies, place_masses(bodies, [near], None, ()))[0, 1]

    # By the far load the beam sinks at 140 by F (3 L s^2 - s^3) / 6; the near one must sink the end as much.
    s, length = 140.0, 270.0
    assert abs(end_under_near) == pytest.approx(9.81 * (3 * length * s**2 - s**3) / 6, rel=1e-9)


@pytest.mark.parametrize("subject", ["link 2", "link 3", "links"])
def test_the_amplitude_of_bending_is_the_sag_of_the_stretched_arm(rigid_bench, at, subject):
    bent = rigid_bench.effect("link_bending", subject, 0.1)

    moved = rigid_bench.moved_mm(at(STRETCHED_DEG), bent)[0]

    # second order: 0.1 mm over 600 mm, and the loads of the bent arm
    assert np.linalg.norm(moved) == pytest.approx(0.1, rel=1e-3)
    assert moved[2] < -0.09


def test_an_upright_arm_hardly_bends(rigid_bench, at):
    bent = rigid_bench.effect("link_bending", "link 2", 0.1)
    folded = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]

    upright, stretched = (
        np.linalg.norm(rigid_bench.moved_mm(at(row), bent)) for row in (folded, STRETCHED_DEG)
    )

    assert upright < stretched  # only the forearm's moment is left


def test_the_sag_grows_with_the_softness_and_adds_up():
    upper, fore = Beam(2, 8e-12), Beam(3, 6e-12)

    sags = [sag_mm(ARM, TOOL, beams) for beams in ((upper,), (fore,), (upper, fore))]

    assert sags[0] + sags[1] == pytest.approx(sags[2], rel=1e-3)
    assert sag_mm(ARM, TOOL, (Beam(2, 16e-12),)) == pytest.approx(2 * sags[0], rel=1e-3)
