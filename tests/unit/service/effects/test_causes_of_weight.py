"""Causes that weight brings about: wrong masses, links that bend, a base that tilts."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign, telling_scene, without_masses
from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.domain.campaign import Stops
from truepose.domain.robot import JointRow, LinkMass, Robot
from truepose.effects.arm.link_bending import beams
from truepose.effects.arm.loads import mass_specs, stated_mass, wrong_mass
from truepose.effects.causes import FittedCause
from truepose.effects.ports import PortKind, Rows, known_frames
from truepose.effects.registry import CAUSES
from truepose.kinematics.chain import forward, nominal_chain, nominal_values
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.gravity import gravity_torques
from truepose.messages.catalogue import english

WEIGHT_CAUSES = ("base_compliance", "link_bending", "link_mass", "payload")
THROUGH_SPRINGS = ("link_mass", "payload")
DOWN = np.array([0.0, 0.0, -9.81])


def rows_at(joints_rad, robot, gravity=DOWN):
    joints = np.atleast_2d(joints_rad).astype(float)
    n = len(joints)
    return Rows(
        stops=Stops(np.arange(n), joints),
        nest=np.ones(n, dtype=int),
        torque_n_mm=None,
        turn_rad=joints,
        frames=known_frames(nominal_chain(robot, joints)),
        gravity_m_s2=gravity,
        robot=robot,
    )


def added_torques(cause, rows, **values):
    """What parameters add to the torques, shape (n, J)."""
    torques = np.zeros_like(rows.stops.joints_rad)
    for term in CAUSES[cause].terms(tuple(values), rows):
        assert term.port.kind is PortKind.TORQUE
        torques[:, term.port.number] += term.weight * list(values.values())[term.parameter]
    return torques


def with_mass(robot, frame, mass_kg, centre):
    others = tuple(mass for mass in robot.masses if mass.frame != frame)
    return replace(robot, masses=(*others, LinkMass(frame, mass_kg, centre)))


def reached(robot, rows, body, motion):
    """Flange of the robot with one body moved."""
    values = nominal_values(robot, rows.stops.joints_rad)
    return forward(values, np.eye(3), np.zeros(3), {body: motion}).end_origin


@pytest.mark.parametrize("cause", WEIGHT_CAUSES)
def test_unknown_masses_hide_it_and_it_has_no_parameters_then(cause):
    scene = telling_scene(("base", "geometry"), telling_campaign(robot=without_masses()))

    assert "not stated" in english(CAUSES[cause].unseen(scene))
    assert CAUSES[cause].candidates(scene) == ()
    assert CAUSES[cause].specs(scene.setting) == ()


@pytest.mark.parametrize("cause", THROUGH_SPRINGS)
def test_a_wrong_mass_shows_only_through_springs_that_gravity_loads(cause):
    rigid = telling_scene(("base", "geometry"))
    scene = telling_scene()
    measured = replace(scene, setting=scene.setting._replace(torque_source="measured"))

    assert "add `compliance`" in english(CAUSES[cause].unseen(rigid))
    assert "were measured" in english(CAUSES[cause].unseen(measured))
    assert CAUSES[cause].candidates(rigid) == CAUSES[cause].candidates(measured) == ()


@pytest.mark.parametrize(
    ("cause", "frame", "prefix"),
    [("payload", 6, ("payload_mass", "payload_")), ("link_mass", 4, ("mass_4", "moment_4_"))],
)
def test_a_wrong_mass_adds_the_torques_of_the_true_mass_less_those_of_the_stated_one(cause, frame, prefix):
    joints = np.random.default_rng(1).uniform(-1.5, 1.5, (8, 6))
    stated = stated_mass(IRB_120, frame - 1)
    extra = 0.4
    centre = np.array(stated.centre_of_gravity_mm) + np.array([10.0, -20.0, 5.0])
    heavier = with_mass(IRB_120, frame, stated.mass_kg + extra, tuple(centre))
    moment = (stated.mass_kg + extra) * centre - stated.mass_kg * np.array(stated.centre_of_gravity_mm)
    values = dict(zip((prefix[0], *(prefix[1] + axis for axis in "xyz")), (extra, *moment), strict=True))
    gravity = np.array([1.0, -2.0, -9.5])  # a base that hangs askew: joint 1 is loaded too

    added = added_torques(cause, rows_at(joints, IRB_120, gravity), **values)

    chain = nominal_chain(IRB_120, joints)
    change = gravity_torques(chain, heavier.masses, gravity) - gravity_torques(chain, IRB_120.masses, gravity)
    assert added == pytest.approx(change, abs=1e-9)  # N mm, of some thousands


def test_links_with_stated_masses_are_tried_one_by_one_and_together_and_the_tool_is_none_of_them():
    candidates = CAUSES["link_mass"].candidates(telling_scene())

    assert [candidate.subject for candidate in candidates] == ["link 2", "link 4", "links"]
    assert candidates[-1].names == candidates[0].names + candidates[1].names


def test_masses_of_one_frame_are_one_mass():
    robot = replace(IRB_120, masses=(LinkMass(6, 1.0, (0.0, 0.0, 50.0)), LinkMass(6, 3.0, (40.0, 0.0, 90.0))))

    assert stated_mass(robot, 5) == LinkMass(6, 4.0, (30.0, 0.0, 80.0))
    assert stated_mass(robot, 4).mass_kg == 0.0


def posterior(specs, truth, information):
    """What a fit with independent priors of mean 0 makes of readings with this information."""
    precision = np.diag([spec.prior_width**-2 for spec in specs])
    covariance = np.linalg.inv(information + precision)
    return FittedCause(tuple(spec.name for spec in specs), covariance @ information @ truth, covariance)


def test_amount_and_centre_of_gravity_are_told_apart_where_the_data_see_all_of_it():
    stated = LinkMass(6, 2.7, (50.0, 25.0, 100.0))
    specs = mass_specs(("m", "x", "y", "z"), stated)
    shift = np.array([6.0, -8.0, 0.0])
    truth = np.array([0.27, *(0.27 * np.array(stated.centre_of_gravity_mm) + 2.7 * shift)])

    wrong = wrong_mass(posterior(specs, truth, 1e6 * np.eye(4)), specs, stated)

    # the data know mass and moments to 1e-3 kg and 1e-3 kg mm, beliefs pull by 1e-6 of that
    assert wrong.extra_kg == pytest.approx(0.27, abs=2e-4)
    assert wrong.shift_mm == pytest.approx(shift, abs=0.02)


def test_where_only_a_moment_is_seen_the_mass_takes_the_share_of_it_that_is_believed():
    stated = LinkMass(2, 4.2, (140.0, 0.0, 0.0))
    specs = mass_specs(("m", "x", "y", "z"), stated)
    moment = np.array([0.0, 1.0, 0.0, 0.0])

    wrong = wrong_mass(posterior(specs, 140.0 * moment, 1e4 * np.outer(moment, moment)), specs, stated)

    # 140 kg mm = 140 mm x extra + 4.2 kg x shift, extra believed to 2.1 kg and the shift to 50 mm
    mass, centre = (140.0 * 2.1) ** 2, (4.2 * 50.0) ** 2
    assert wrong.extra_kg == pytest.approx(140.0 * mass / (mass + centre) / 140.0, rel=1e-3)
    assert wrong.extra_spread_kg == pytest.approx(2.1 * np.sqrt(centre / (mass + centre)), rel=1e-3)
    assert wrong.shift_mm[0] == pytest.approx(140.0 * centre / (mass + centre) / 4.2, rel=1e-3)


def test_a_moment_that_is_known_exactly_is_shared_out_like_one_that_is_known_well():
    stated = LinkMass(2, 4.2, (140.0, 0.0, 0.0))
    specs = mass_specs(("m", "x", "y", "z"), stated)
    moment = np.array([0.0, 1.0, 0.0, 0.0])
    well = posterior(specs, 140.0 * moment, 1e4 * np.outer(moment, moment))
    exact = well.covariance * np.outer(1.0 - moment, 1.0 - moment)

    wrong = wrong_mass(well._replace(covariance=exact), specs, stated)

    known = wrong_mass(well, specs, stated)
    assert wrong.extra_kg == pytest.approx(known.extra_kg, rel=1e-3)
    assert wrong.extra_spread_kg == pytest.approx(known.extra_spread_kg, rel=1e-3)
    assert wrong.shift_mm == pytest.approx(known.shift_mm, rel=1e-3, abs=1e-9)


def test_data_that_see_nothing_of_a_mass_leave_belief():
    stated = LinkMass(6, 2.0, (0.0, 0.0, 100.0))
    specs = mass_specs(("m", "x", "y", "z"), stated)

    wrong = wrong_mass(posterior(specs, np.ones(4), np.zeros((4, 4))), specs, stated)

    assert wrong.extra_kg == pytest.approx(0.0, abs=1e-12)
    assert wrong.extra_spread_kg == pytest.approx(1.0)  # half of 2 kg
    assert wrong.shift_spread_mm == pytest.approx([50.0, 50.0, 50.0])


def test_a_payload_is_told_in_kilograms_with_its_centre_of_gravity():
    scene = telling_scene()
    (candidate,) = CAUSES["payload"].candidates(scene)
    truth = np.array([0.27, *(0.27 * np.array([50.0, 25.0, 100.0]))])

    shown = CAUSES["payload"].describe("tool", posterior(candidate.specs, truth, 1e6 * np.eye(4)), scene)

    assert (shown.amplitude, shown.unit) == (pytest.approx(0.27, abs=1e-3), "kg")
    assert [detail.unit for detail in shown.details] == ["mm"] * 3
    assert "weighs 0.27 kg more than the 2.7 kg stated" in english(shown.sentence)


def test_of_several_links_the_one_that_is_off_most_is_named():
    scene = telling_scene()
    together = CAUSES["link_mass"].candidates(scene)[-1]
    truth = np.array([0.1, 14.0, 0.0, 0.0, -0.8, 0.0, 0.0, 154.9])

    shown = CAUSES["link_mass"].describe("links", posterior(together.specs, truth, 1e8 * np.eye(8)), scene)

    assert shown.amplitude == pytest.approx(-0.8, abs=1e-3)
    assert "most of all that of link 4. This link weighs 0.80 kg less than the 5 kg stated" in english(
        shown.sentence
    )
    assert {detail.name.split(":")[0] for detail in shown.details} == {"link 2", "link 4"}


def level_beam():
    """A beam of 400 mm on axis 2, level in the zero configuration, that carries 3 kg at its end."""
    return Robot(
        name="beam",
        joints=(
            JointRow(0.0, 0.0, 0.0, 0.0),
            JointRow(-np.pi / 2, 0.0, 0.0, 0.0),
            JointRow(0.0, 400.0, 0.0, 0.0),
            JointRow(0.0, 0.0, 0.0, 0.0),
        ),
        masses=(LinkMass(3, 3.0, (0.0, 0.0, 0.0)),),
    )  # fmt: skip


def bent_end(robot, rows, per_ei, link=2):
    motion = np.zeros((len(rows.stops), 6))
    for term in CAUSES["link_bending"].terms((f"sag_{link}",), rows):
        assert term.port.kind is PortKind.MOTION
        motion[:, term.port.number - 6 * link] += per_ei * term.weight
    return reached(robot, rows, link, motion) - reached(robot, rows, link, np.zeros_like(motion)), motion


def test_a_level_beam_with_a_weight_at_its_end_sags_as_in_the_textbook():
    robot, per_ei = level_beam(), 1e-12
    rows = rows_at(np.zeros(4), robot)

    sag, motion = bent_end(robot, rows, per_ei)

    # F L^3 / 3 EI down, turned by F L^2 / 2 EI; second order of a turn of 2e-6 is left out
    assert sag[0] == pytest.approx([0.0, 0.0, -3.0 * 9.81 * 400.0**3 / 3.0 * per_ei], abs=1e-8)
    assert np.linalg.norm(motion[0, 3:]) == pytest.approx(3.0 * 9.81 * 400.0**2 / 2.0 * per_ei, rel=1e-9)


def test_a_weight_halfway_along_a_beam_bends_only_that_half():
    robot = replace(level_beam(), masses=(LinkMass(2, 3.0, (200.0, 0.0, 0.0)),))
    per_ei = 1e-12

    sag, _ = bent_end(robot, rows_at(np.zeros(4), robot), per_ei)

    # F a^2 (3 L - a) / 6 EI at the free end
    assert sag[0, 2] == pytest.approx(-3.0 * 9.81 * 200.0**2 * (1200.0 - 200.0) / 6.0 * per_ei, rel=1e-5)


def test_a_weight_beyond_the_end_of_a_beam_brings_its_moment_along():
    robot = replace(level_beam(), masses=(LinkMass(3, 3.0, (100.0, 0.0, 0.0)),))
    per_ei = 1e-12

    sag, _ = bent_end(robot, rows_at(np.zeros(4), robot), per_ei)

    force = 3.0 * 9.81
    assert sag[0, 2] == pytest.approx(
        -(force * 400.0**3 / 3.0 + force * 100.0 * 400.0**2 / 2.0) * per_ei, rel=1e-5
    )


def test_an_upright_beam_does_not_bend():
    robot = level_beam()

    sag, _ = bent_end(robot, rows_at([0.0, -np.pi / 2, 0.0, 0.0], robot), 1e-12)

    assert np.abs(sag).max() < 1e-12


def test_beams_are_the_long_links_between_column_and_wrist():
    assert {link: round(beam.length_mm) for link, beam in beams(IRB_120).items()} == {2: 270, 3: 310}
    assert beams(IRB_120)[2].carries == (2,)
    assert beams(IRB_120)[3].carries == (3, 4)  # the forearm's roll joint sits on it
    assert sorted(beams(SEVEN_AXES)) == [2, 4]


def test_bending_is_told_as_the_sag_of_the_stretched_arm():
    scene = telling_scene()
    upper, both = 8e-12, (8e-12, 6e-12)

    alone = CAUSES["link_bending"].describe(
        "link 2", FittedCause(("sag_2",), np.array([upper]), np.eye(1) * 1e-26), scene
    )
    together = CAUSES["link_bending"].describe(
        "links", FittedCause(("sag_2", "sag_3"), np.array(both), np.diag([1e-26, 1e-26])), scene
    )

    # Straight from the elbow the wrist is 310 mm away and the flange 72 mm further. On the forearm 5 kg sit
    # 193.6 mm before the wrist, 121 mm from the elbow; the tool's 2.7 kg are 100 mm beyond the flange; 4.2 kg
    # sit on the upper arm itself, at 140 of 270 mm.
    force, beyond = 9.81 * np.array([5.0, 2.7]), np.array([121.0, 482.0])
    turn = (force * 270.0**2 / 2.0 + force * beyond * 270.0).sum() + 4.2 * 9.81 * 140.0**2 / 2.0
    shift = (force * 270.0**3 / 3.0 + force * beyond * 270.0**2 / 2.0).sum()
    shift += 4.2 * 9.81 * 140.0**2 * (3.0 * 270.0 - 140.0) / 6.0
    # what the tool's centre lies beside its axis, and angles searched in whole degrees, come to less
    assert alone.amplitude == pytest.approx((shift + 382.0 * turn) * upper, rel=5e-3)
    assert alone.unit == "mm"
    assert together.amplitude > alone.amplitude
    assert together.standard_uncertainty > alone.standard_uncertainty
    assert "Links 2 and 3 bend" in english(together.sentence)


def test_a_base_tilts_by_its_compliance_times_the_moment_of_all_weights_about_itself():
    joints = np.random.default_rng(2).uniform(-1.5, 1.5, (6, 6))
    askew = rotation_from_vector(np.array([0.3, -0.2, 0.5]))
    origin = np.array([100.0, -50.0, 30.0])
    chain = forward(nominal_values(IRB_120, joints), askew, origin)
    rows = rows_at(joints, IRB_120)._replace(frames=known_frames(chain))

    terms = CAUSES["base_compliance"].terms(("base_c",), rows)

    turn = np.stack([term.weight for term in sorted(terms, key=lambda term: term.port.number)], axis=1)
    moment = np.zeros((6, 3))
    for mass in IRB_120.masses:
        place = chain.origin[mass.frame - 1] + chain.rotation[mass.frame - 1] @ np.array(
            mass.centre_of_gravity_mm
        )
        moment += np.cross(place - origin, mass.mass_kg * DOWN)
    assert [term.port.number for term in terms] == [3, 4, 5]
    assert turn @ askew.T == pytest.approx(moment, abs=1e-6)  # N mm, of some ten thousand
    assert (turn @ askew.T)[:, 2] == pytest.approx(0.0, abs=1e-6)  # a tilt about a level axis


def test_a_soft_base_is_told_in_radians_per_moment():
    shown = CAUSES["base_compliance"].describe(
        "base", FittedCause(("base_c",), np.array([5e-9]), np.array([[1e-20]])), telling_scene()
    )

    assert (shown.amplitude, shown.unit) == (5e-9, "rad/(N*mm)")
    assert shown.standard_uncertainty == pytest.approx(1e-10)
