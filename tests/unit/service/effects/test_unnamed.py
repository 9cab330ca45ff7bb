"""Causes without a trade name: what each kind of cell moves, when it is looked for, and how it is told."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    ORIGIN_S,
    START,
    TRACKER_MM,
    rows_at_start,
    telling_campaign,
    telling_problem,
    telling_scene,
    without_masses,
)
from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS
from truepose.effects.causes import FittedCause
from truepose.effects.ports import Port, PortKind, motion_port
from truepose.effects.registry import CAUSES, needs_of
from truepose.effects.unclassified.cause import KINDS
from truepose.effects.unclassified.kinds import key_of
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import evaluate, rows_of
from truepose.identification.problem.build import build
from truepose.kinematics.frames import cross
from truepose.messages.catalogue import english

UNNAMED = CAUSES["unnamed"]
UP = np.array([0.0, 0.0, 1.0])
# A weight is taken where the arm is without the parameter, a load too: a hundredth of the motion at most.
_RELATIVE = 0.01


def kinds_of(candidates):
    return {key_of(candidate.names[0]).kind for candidate in candidates}


@cache
def usual_candidates():
    return UNNAMED.candidates(telling_scene())


def candidate_of(kind):
    """The last cell of a kind: places with high numbers are more telling than the first."""
    return [candidate for candidate in usual_candidates() if key_of(candidate.names[0]).kind == kind][-1]


def state_with(specs, values):
    problem = telling_problem()
    structure = problem.structure.extended("unnamed", specs)
    return evaluate(structure, np.concatenate([problem.start, values]), problem.blocks[0].targets)


def described(names, values, spread=1e-9):
    fitted = FittedCause(tuple(names), np.array(values, dtype=float), spread**2 * np.eye(len(values)))
    subject = next(c.subject for c in usual_candidates() if c.names[0] == names[0])
    return UNNAMED.describe(subject, fitted, telling_scene())


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_agree_with_differences_of_the_evaluated_model(kind):
    specs = candidate_of(kind).specs
    jacobian = position_jacobian(state_with(specs, np.zeros(len(specs))))[-len(specs) :]

    for parameter, spec in enumerate(specs):
        step = 0.1 * spec.prior_width * np.eye(len(specs))[parameter]
        moved = state_with(specs, step).position_mm - state_with(specs, -step).position_mm
        difference = moved / (0.2 * spec.prior_width)
        assert np.abs(difference).max() > 0.0
        assert jacobian[parameter] == pytest.approx(difference, abs=_RELATIVE * np.abs(difference).max())


@pytest.mark.parametrize(
    ("name", "port", "weight"),
    [
        ("cell_wobble_6_2_sin-rx", motion_port(6, 3), lambda turn: np.sin(2.0 * turn[5])),
        ("cell_wobble_6_2_cos-z", motion_port(6, 2), lambda turn: np.cos(2.0 * turn[5])),
        ("cell_cross_6-5_3_sin", Port(PortKind.THETA, 5), lambda turn: np.sin(3.0 * turn[4])),
        ("cell_cross_6-5_3_cos", Port(PortKind.THETA, 5), lambda turn: np.cos(3.0 * turn[4])),
        ("cell_along_3-6_line_share", Port(PortKind.THETA, 2), lambda turn: turn[5]),
        ("cell_pair_3-2_2_sin", Port(PortKind.THETA, 2), lambda turn: np.sin(2.0 * (turn[1] + turn[2]))),
        ("cell_pair_2-2_1_cos", Port(PortKind.THETA, 1), lambda turn: np.cos(turn[1] + turn[2])),
    ],
)
def test_what_follows_an_angle_follows_its_waves_or_a_share_of_it(name, port, weight):
    rows = rows_at_start(telling_problem())

    (term,) = UNNAMED.terms((name,), rows)

    assert term.port == port
    assert term.weight == pytest.approx(weight(rows.turn_rad.T))


def test_parallel_axes_that_point_against_each_other_turn_a_link_by_the_difference_of_their_angles():
    joints = list(IRB_120.joints)
    joints[2] = replace(joints[2], alpha_rad=np.pi)
    rows = rows_at_start(telling_problem())._replace(robot=replace(IRB_120, joints=tuple(joints)))

    (term,) = UNNAMED.terms(("cell_pair_3-2_1_sin",), rows)

    assert term.weight == pytest.approx(np.sin(rows.turn_rad[:, 1] - rows.turn_rad[:, 2]))


def test_names_lead_back_to_the_cell_and_are_given_once():
    candidates = usual_candidates()
    names = [name for candidate in candidates for name in candidate.names]

    assert len(set(names)) == len(names)
    assert [key_of(name).name for name in names] == names
    assert kinds_of(candidates) == set(KINDS)


@pytest.mark.parametrize(
    ("column", "lost"),
    [
        ("time_s", {"jump", "drift", "slip", "kick"}),
        ("temperature_c", {"warm", "stretch"}),
        ("direction", {"rub"}),
        ("move_rad", {"lag"}),
    ],
)
def test_a_cell_is_not_looked_for_where_readings_do_not_tell_what_it_depends_on(column, lost):
    scene = telling_scene()

    left = UNNAMED.candidates(replace(scene, stops=replace(scene.stops, **{column: None})))

    assert kinds_of(left) == set(KINDS) - lost


@pytest.mark.parametrize(
    ("changes", "lost"),
    [({"instrument_mm": None}, {"azimuth", "elevation"}), ({"legs": True}, {"kick", "azimuth", "elevation"})],
)
def test_errors_of_an_instrument_need_an_instrument_whose_place_is_known(changes, lost):
    found = kinds_of(UNNAMED.candidates(telling_scene(**changes)))

    assert found & {"kick", "azimuth", "elevation"} == {"kick", "azimuth", "elevation"} - lost


def test_bearings_need_masses_that_load_them():
    scene = telling_scene(("base", "geometry"), telling_campaign(robot=without_masses()))

    assert not {"tilt", "mount"} & kinds_of(UNNAMED.candidates(scene))


def test_a_flange_that_nothing_hangs_on_shows_no_mount():
    bare = replace(IRB_120, masses=tuple(mass for mass in IRB_120.masses if mass.frame < 6))
    scene = telling_scene(campaign=telling_campaign(robot=bare))

    assert kinds_of(UNNAMED.candidates(scene)) & {"tilt", "mount"} == {"tilt"}


def test_the_last_bearing_is_told_by_the_flange_alone():
    found = usual_candidates()

    assert [c.subject for c in found if key_of(c.names[0]).kind == "tilt"] == [
        f"link {joint}, load, line" for joint in (2, 3, 4, 5)
    ]
    assert {c.subject for c in found if key_of(c.names[0]).kind == "mount"} == {"flange, load, line"}


def test_a_mount_that_gives_lets_the_tool_nod_and_drop():
    """At zero the flange faces forward: the weight pulls along the x of its frame and turns about its y."""
    zero = telling_campaign(joints_rad=np.zeros((24, 6)))
    problem, mount = build(zero, ("base", "geometry")), candidate_of("mount")
    structure, targets = problem.structure.extended("unnamed", mount.specs), problem.blocks[0].targets
    tilt, shift, weight_n = 1e-7, 1e-4, 9.81 * IRB_120.masses[-1].mass_kg

    still, given = (
        evaluate(structure, np.append(problem.start, values), targets).position_mm
        for values in ([0.0, 0.0], [tilt, shift])
    )

    nod_rad = tilt * weight_n * IRB_120.masses[-1].centre_of_gravity_mm[2]
    ahead_mm = np.array(NESTS)[zero.calibration.nest - 1, 2]
    drop_mm = shift * weight_n + nod_rad * ahead_mm
    assert (still - given)[:, 2] == pytest.approx(drop_mm, rel=1e-3)
    assert (still - given)[:, 1] == pytest.approx(0.0, abs=1e-6)


def test_joints_that_hardly_turn_show_no_waves():
    still = telling_scene(turn_rad=np.zeros((24, 6)))

    assert not kinds_of(UNNAMED.candidates(still)) & {"wobble", "cross", "along", "pair"}


def test_joints_that_hardly_move_between_stops_show_no_lag():
    scene = telling_scene()
    creeping = replace(scene.stops, move_rad=0.01 * np.ones((24, 6)))

    assert "lag" not in kinds_of(UNNAMED.candidates(replace(scene, stops=creeping)))


def test_an_even_load_is_no_varying_one_where_it_is_not_known():
    scene = telling_scene()
    load_n_mm = np.full((len(scene.stops), 6), 5e4)
    load_n_mm[::5] = np.nan
    load_n_mm[1::5, 2] = -2e4

    subjects = [c.subject for c in UNNAMED.candidates(replace(scene, torque_n_mm=load_n_mm))]

    assert [subject for subject in subjects if "torque" in subject] == ["joint 3, torque of joint 3, sign"]


def test_moves_that_are_not_known_do_not_hide_a_joint_that_moves_far():
    scene = telling_scene()
    move_rad = np.full((len(scene.stops), 6), np.nan)
    move_rad[::4, 2] = np.deg2rad(7.0)

    places = [
        c.subject for c in UNNAMED.candidates(replace(scene, stops=replace(scene.stops, move_rad=move_rad)))
    ]

    assert [subject for subject in places if "last move" in subject] == ["joint 3, last move, line"]


def test_a_joint_that_lags_stays_behind_by_a_share_of_its_move():
    specs = [spec for c in usual_candidates() for spec in c.specs if "lag_2" in spec.name]
    stops = telling_campaign().calibration.stops
    behind = stops.joints_rad.copy()
    behind[1:, 1] -= 1e-4 * np.diff(stops.joints_rad[:, 1])

    lagging = state_with(specs, np.array([1e-4]))

    problem = telling_problem()
    held = replace(problem.blocks[0].targets, stops=replace(stops, joints_rad=behind))
    assert lagging.position_mm == pytest.approx(
        evaluate(problem.structure, problem.start, held).position_mm, abs=1e-6
    )


def test_a_row_that_tells_nothing_leaves_every_cell_but_those_of_angles_and_loads_at_rest():
    state = state_with((), [])
    stops = replace(state.targets.stops, time_s=None, temperature_c=None, direction=None, move_rad=None)
    rows = rows_of(state)._replace(stops=stops, instrument_mm=None)
    at_rest = set(KINDS) - {"wobble", "cross", "along", "pair", "tilt", "mount"}

    for kind in at_rest:
        terms = UNNAMED.terms(candidate_of(kind).names, rows)
        assert not any(np.any(term.weight) for term in terms), kind


def test_a_parallelogram_joins_parallel_axes_only():
    found = [c for c in usual_candidates() if key_of(c.names[0]).kind == "pair"]

    assert {c.subject for c in found} == {
        "joint 2, angles of joints 2 and 3, wave",
        "joint 3, angles of joints 2 and 3, wave",
    }


def test_links_that_have_a_length_grow_and_no_others():
    found = [c.subject for c in usual_candidates() if key_of(c.names[0]).kind == "stretch"]

    lengths = [abs(row.a_mm) + abs(row.d_mm) for row in IRB_120.joints]
    assert lengths == [290.0, 0.0, 270.0, 372.0, 0.0, 72.0]
    assert found == [f"{part}, temperature, line" for part in ("base", "link 2", "link 3", "link 5")]


def test_a_candidate_stays_the_same_whatever_its_size():
    one, other = candidate_of("cross"), candidate_of("along")
    large = one.sized(3.0).sized(2.0)

    assert large.same_as(one)
    assert not other.same_as(one)
    assert (large.size, large.specs[0].prior_width) == (6.0, pytest.approx(6.0 * one.specs[0].prior_width))


def test_an_error_in_azimuth_turns_what_is_read_about_the_instrument():
    specs = candidate_of("azimuth").specs
    still, turned = (state_with(specs, np.array([0.0, size])) for size in (0.0, 1e-6))
    arms = still.position_mm - TRACKER_MM
    azimuth = np.arctan2(arms[:, 1], arms[:, 0])

    wanted = 1e-6 * np.cos(2.0 * azimuth)[:, None] * cross(UP, arms)

    assert turned.position_mm - still.position_mm == pytest.approx(wanted, abs=1e-7)


def test_an_error_in_elevation_keeps_distances_and_lifts():
    specs = candidate_of("elevation").specs
    still, lifted = (state_with(specs, np.array([0.0, size])) for size in (0.0, 1e-6))
    arms = still.position_mm - TRACKER_MM
    elevation = np.arctan2(arms[:, 2], np.hypot(arms[:, 0], arms[:, 1]))

    moved = lifted.position_mm - still.position_mm

    assert np.einsum("ni,ni->n", moved, arms) == pytest.approx(0.0, abs=1e-6)
    level = np.hypot(arms[:, 0], arms[:, 1])
    assert moved[:, 2] == pytest.approx(1e-6 * np.cos(2.0 * elevation) * level, abs=1e-7)


def test_fixed_nests_are_seen_under_their_own_azimuth():
    problem = build(telling_campaign(), START, with_reference=True)
    block = problem.blocks[1]

    rows = rows_of(evaluate(problem.structure, problem.start, block.targets))

    assert rows.sighted_mm is block.targets.fixed_mm
    assert rows.sighted_mm == pytest.approx(block.certified_mm)


def test_a_jump_is_told_with_its_size_and_its_moment():
    told = described([f"cell_jump_3_{ORIGIN_S + 345.0:.0f}_turn"], [np.deg2rad(-0.010)])

    assert english(told.sentence) == (
        "The zero of joint 3 jumped by 0.0100 deg, 6 min after the first reading; nothing else moved then."
    )
    assert (told.subject, told.unit) == ("joint 3, time, jump", "deg")
    assert told.amplitude == pytest.approx(-0.010)
    (moment,) = told.details
    assert (moment.name, moment.value, moment.unit) == ("time", ORIGIN_S + 345.0, "s")
    assert moment.standard_uncertainty == pytest.approx(30.0 / np.sqrt(12.0))  # readings are 30 s apart


def test_of_many_readings_not_every_gap_is_tried_and_the_moment_is_known_less_well():
    scene = telling_scene(campaign=telling_campaign(200))
    jumps = [c for c in UNNAMED.candidates(scene) if c.subject == "joint 3, time, jump"]

    fitted = FittedCause(jumps[20].names, np.array([1e-4]), np.array([[1e-12]]))
    (moment,) = UNNAMED.describe(jumps[20].subject, fitted, scene).details

    assert len(jumps) <= 60
    assert moment.standard_uncertainty == pytest.approx(4 * 30.0 / np.sqrt(12.0))  # every fourth gap


@pytest.mark.parametrize("readings", [24, 100, 200])
def test_a_kick_is_tried_whenever_the_base_may_have_jumped(readings):
    scene = telling_scene(campaign=telling_campaign(readings))

    kicks = [c for c in UNNAMED.candidates(scene) if c.subject == "tracker, time, jump"]

    assert [c.variant for c in kicks] == [c.variant for c in CAUSES["base_shift"].candidates(scene)]
    (moment, _) = UNNAMED.describe(
        kicks[8].subject, FittedCause(kicks[8].names, np.full(6, 1e-4), 1e-12 * np.eye(6)), scene
    ).details
    apart_s = kicks[9].variant - kicks[8].variant
    assert moment.standard_uncertainty == pytest.approx(apart_s / np.sqrt(12.0))


def test_of_several_jumps_of_one_place_the_largest_is_told_and_all_are_listed():
    names = [f"cell_jump_3_{ORIGIN_S + after:.0f}_turn" for after in (345.0, 405.0)]

    told = described(names, np.deg2rad([0.004, -0.02]))

    assert told.amplitude == pytest.approx(-0.02)
    assert "the largest of 2 such jumps" in english(told.sentence)
    assert [detail.name for detail in told.details] == ["time", "amplitude"] * 2


def test_a_tool_that_slipped_is_told_with_shift_and_turn():
    names = candidate_of("slip").names

    told = described(names, [0.03, 0.0, 0.04, 0.0, 3e-4, 0.0])

    assert told.amplitude == pytest.approx(0.05)
    assert "slipped in its seat by 0.050 mm and turned by 0.0172 deg" in english(told.sentence)
    assert [detail.name for detail in told.details] == ["time", "rotation"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_told_in_one_plain_sentence(kind):
    candidate = candidate_of(kind)
    values = [0.3 * spec.prior_width for spec in candidate.specs]

    told = described(candidate.names, values)

    assert english(told.sentence)[0].isupper()
    assert english(told.sentence).endswith(".")
    assert english(told.sentence).count(". ") == 0
    assert told.subject == candidate.subject
    assert abs(told.amplitude) > told.standard_uncertainty > 0.0


@pytest.mark.parametrize(
    ("kind", "needs"),
    [
        ("jump", {"time"}),
        ("kick", {"time"}),
        ("warm", {"temperature"}),
        ("rub", {"torque", "direction"}),
        ("lag", {"move"}),
        ("cross", set()),
    ],
)
def test_a_model_asks_of_rows_what_its_cells_depend_on(kind, needs):
    assert needs_of("unnamed", candidate_of(kind).names) == needs
    assert needs_of("unnamed", (*candidate_of(kind).names, *candidate_of("drift").names)) == needs | {"time"}


def test_friction_that_follows_the_load_is_loaded_also_where_the_model_has_no_spring():
    specs = candidate_of("rub").specs
    problem = telling_problem(("base", "geometry"))
    structure, values = problem.structure.extended("unnamed", specs), np.append(problem.start, 1e-7)

    state = evaluate(structure, values, problem.blocks[0].targets)

    assert np.abs(state.position_mm - state_with((), []).position_mm).max() > 1e-5
