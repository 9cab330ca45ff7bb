import numpy as np
import pytest

from tests.unit.simulators.model_documents import AT_THE_WORLD, robot_document
from truepose_simulators.errors import ModelError
from truepose_simulators.physics.effects import Conditions
from truepose_simulators.physics.identified import realise
from truepose_simulators.physics.true_robot import find_rest

# Each row is about an effect and a parameter that its physics has no meaning for.
STRANGE = [
    ("backlash", "gap"),
    ("base", "base_w"),
    ("base_compliance", "base_c_2"),
    ("base_drift", "drift_sudden_x"),
    ("base_shift", "jump_x"),
    ("compliance", "c_2*mz_3"),
    ("compliance_nonlinear", "soft_2"),
    ("geometry", "gamma_2"),
    ("instrument_drift", "drift_linear_x"),
    ("instrument_scale", "scale_2"),
    ("joint_coupling", "coupling_6"),
    ("joint_gain", "gain_two"),
    ("joint_harmonics", "wave_6_2"),
    ("link_bending", "sag"),
    ("link_mass", "moment_2"),
    ("nest_offset", "offset_1_rx"),
    ("payload", "payload_w"),
    ("thermal_growth", "growth_2"),
    ("tool", "nest_x"),
    ("tool_certificate", "certified_1_rx"),
    ("tool_reseating", "seat_x"),
]
BEYOND = [
    ("backlash", "gap_7", "no joint 7; there are 6"),
    ("compliance", "c_2*mx_7", "no joint 7; there are 6"),
    ("geometry", "alpha_9", "no joint 9; there are 6"),
    ("joint_coupling", "coupling_6_0", "no joint 0; there are 6"),
    ("joint_harmonics", "wave_7_2_sin", "no joint 7; there are 6"),
    ("link_bending", "sag_6", "no link with a joint at its end 6; there are 5"),
    ("link_mass", "mass_8", "no link 8; there are 6"),
    ("nest_offset", "offset_2_x", "no nest 2; there are 1"),
    ("tool", "nest_4_x", "no nest 4; there are 1"),
    ("tool_certificate", "certified_2_x", "no nest 2; there are 1"),
]


@pytest.fixture
def places(load):
    """Positions of nest 1 at the zero configuration and where else it is asked for, (n, 3)."""

    def at(*parameters, joints_rad=((0.0,) * 6,), direction=0.0, time_s=0.0, **changes):
        robot = realise(load(*parameters, **changes))
        joints = np.array(joints_rad, dtype=float)
        n = len(joints)
        ways = np.full_like(joints, direction)
        conditions = Conditions(joints, ways, np.full(n, time_s), np.full(n, 20.0), np.ones(n))
        arm = [effect for effect in robot.effects if hasattr(effect, "deflect")]
        masses = [
            change
            for effect in robot.effects
            if hasattr(effect, "mass_changes")
            for change in effect.mass_changes(conditions)
        ]
        return find_rest(robot.plant, arm, conditions, masses).nest_positions(robot.nests_mm)[:, 0]

    return at


@pytest.mark.parametrize(("effect", "name"), STRANGE)
def test_a_parameter_without_physics_is_refused_by_its_name(load, effect, name):
    with pytest.raises(ModelError, match=f"effect {effect}: the simulator has no parameter") as refused:
        realise(load((effect, name, 1e-4, "1")))

    assert f'"{name}"' in str(refused.value)


@pytest.mark.parametrize(("effect", "name", "sentence"), BEYOND)
def test_a_part_that_the_robot_does_not_have_is_refused(load, effect, name, sentence):
    with pytest.raises(ModelError, match=f"effect {effect}: there is {sentence}"):
        realise(load((effect, name, 1e-4, "1")))


@pytest.mark.parametrize("effect", ["label_swap", "outliers", "own_idea"])
def test_an_effect_without_physics_is_refused_by_its_name(load, effect):
    with pytest.raises(ModelError, match=f"effect {effect}: the simulator does not know this effect"):
        realise(load(effects=[effect]))


def test_a_link_without_length_cannot_bend(load):
    with pytest.raises(ModelError, match="link 4 is shorter than 1 mm and cannot bend"):
        realise(load(("link_bending", "sag_4", 1e-12, "1/(N*mm2)")))


def test_how_it_was_measured_is_no_effect_of_the_robot(load):
    gauge = [
        ("legs", "length_offset", 1.0, "mm"),
        ("reference", "frame_x", 0.1, "mm"),
        ("ballbar_zero", "zero_3", 0.01, "mm"),
        ("fixture_shift", "shift_1_120.5_x", 0.1, "mm"),
    ]

    assert realise(load(*gauge, effects=[])).effects == ()


def test_a_scale_is_that_of_the_instrument_whose_name_it_bears(load):
    parameters = [("instrument_scale", "scale", 1e-5, "1"), ("instrument_scale", "ballbar_scale", 2e-5, "1")]

    tracker, ballbar = realise(load(*parameters)).effects

    assert tracker.relative_scale(np.zeros(1)) == pytest.approx([1e-5])
    assert ballbar.relative_length(np.zeros(1)) == pytest.approx([2e-5])


def test_a_nest_is_off_by_what_its_certificate_allowed(load):
    (offset,) = realise(load(("tool_certificate", "certified_1_y", 0.002, "mm"))).effects
    stop = Conditions(np.zeros((1, 6)), np.zeros((1, 6)), np.zeros(1), np.full(1, 20.0), np.ones(1))

    assert offset.nest_offsets_mm(stop) == pytest.approx(np.array([[[0.0, 0.002, 0.0]]]))


def test_the_nominal_robot_stands_as_its_drawing_shows(places):
    assert places() == pytest.approx(np.array([[374.0 + 125.0, 0.0, 630.0]]), abs=1e-9)


def test_the_base_turns_about_its_own_start(places):
    start = {**AT_THE_WORLD, "x_mm": 100.0, "rz_deg": 90.0}

    turned = places(("base", "base_rz", 90.0, "deg"), ("base", "base_x", 5.0, "mm"), base_in_world=start)

    assert turned == pytest.approx(np.array([[105.0 - 499.0, 0.0, 630.0]]), abs=1e-9)


def test_a_base_drifts_along_its_own_axes(places):
    turned = {**AT_THE_WORLD, "rz_deg": 90.0}
    drift = ("base_drift", "drift_linear_x", 0.1, "mm/h")

    moved = places(drift, base_in_world=turned, time_s=7200.0) - places(base_in_world=turned)

    assert moved == pytest.approx(np.array([[0.0, 0.2, 0.0]]), abs=1e-9)


def test_a_settling_base_comes_to_the_rate_times_its_time_constant(places):
    drift = ("base_drift", "drift_exp600_z", 0.6, "mm/h")

    moved = places(drift, time_s=1e6) - places()

    assert moved == pytest.approx(np.array([[0.0, 0.0, 0.1]]), abs=1e-9)


@pytest.mark.parametrize(("time_s", "jumped"), [(734.0, 0.0), (735.0, 0.3)])
def test_a_jump_is_at_its_time_of_the_campaign_not_of_the_cell(places, time_s, jumped):
    jump = ("base_shift", "jump_1234.5_y", 0.3, "mm")

    moved = places(jump, origin_s=500.0, time_s=time_s) - places()

    assert moved == pytest.approx(np.array([[0.0, jumped, 0.0]]), abs=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_wave_turns_the_joint_about_the_axis_of_its_table(places, sign):
    robot = robot_document()
    robot["dhm_nominal"][0]["sign"] = sign
    wave = [("joint_harmonics", "wave_1_3_cos", 2e-3, "rad"), ("joint_harmonics", "wave_1_3_sin", 9.0, "deg")]

    moved = places(*wave, robot=robot) - places(robot=robot)

    # At zero only the cosine is there, the same way whichever way the joint counts: 499 mm of lever.
    assert moved[0, 1] == pytest.approx(499.0 * 2e-3, rel=1e-5)


def test_backlash_stops_short_as_the_joint_counts(places):
    robot = robot_document()
    robot["dhm_nominal"][0]["sign"] = -1
    gap = ("backlash", "gap_1", 4e-4, "rad")

    moved = places(gap, robot=robot, direction=1.0) - places(robot=robot)

    # Half the gap back from a motion that is clockwise seen from above: anticlockwise.
    assert moved[0, 1] == pytest.approx(499.0 * 2e-4, rel=1e-5)


def test_springs_carry_weights_that_no_mass_states(places):
    springs = [("compliance", f"c_{joint}*mx_3", 1e-4, "rad*s2/m") for joint in (1, 2)]
    level = ((0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0),)

    moved = places(*springs, joints_rad=level, robot=robot_document(masses=[]))
    still = places(joints_rad=level, robot=robot_document(masses=[]))

    # x of frame 3 then points forward: a unit moment turns joint 2 down by 1e-4 * 9.81, joint 1 not at all;
    # that it hangs a little lower by then makes 1e-6 of it.
    lever = still[0] - [0.0, 0.0, 290.0]
    turned = 9.81e-4 * np.array([lever[2], 0.0, -lever[0]])
    assert moved[0] - still[0] == pytest.approx(turned, abs=1e-3)


def test_a_lighter_tool_than_nothing_is_still_a_weight(places):
    # No tool is stated: half a kilogram less than nothing lifts the flange as half a kilogram bears it down.
    spring = ("compliance", "c_2", 1e-6, "rad/(N*mm)")
    nothing = robot_document(masses=[])

    lifted = places(spring, ("payload", "payload_mass", -0.5, "kg"), robot=nothing)
    loaded = places(spring, ("payload", "payload_mass", 0.5, "kg"), robot=nothing)

    plain = places(spring, robot=nothing)
    # 374 mm from joint 2 at both: 0.5 * 9.81 * 374 * 1e-6 rad, on a lever of 499 mm to the nest.
    assert plain[0, 2] - loaded[0, 2] == pytest.approx(0.5 * 9.81 * 374.0 * 1e-6 * 499.0, rel=1e-2)
    assert lifted[0] - plain[0] == pytest.approx(plain[0] - loaded[0], abs=0.01)
