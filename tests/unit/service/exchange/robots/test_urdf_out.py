"""Identified models as URDF, read back by a reader that knows nothing of the service, and by its own."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.models import (
    EXTENSIONS,
    ROBOTS,
    extended,
    model_of,
    parameters_of,
    plain_parameters,
)
from tests.helpers.identification.zones import zoned
from tests.helpers.kinematics.urdf_frames import frames
from truepose.domain.campaign import Stops
from truepose.domain.robot import JointRange
from truepose.exchange.models.exports import export
from truepose.exchange.robots.urdf_import import urdf_from_text
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import predict
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.messages.catalogue import english

NANOMETRE_M = 1e-9


def geometric(robot, *more, **changes):
    parameters = [p for p in plain_parameters(robot) if p.effect != "compliance"]
    return model_of(robot, *parameters, *more, **changes)


def tilted(robot):
    return geometric(robot, *parameters_of("axis_parallelism", [("beta_3", 2e-3, "rad")]))


@pytest.fixture(params=ROBOTS)
def model(request):
    return tilted(ROBOTS[request.param])


def angles(model, n=1000):
    return np.random.default_rng(7).uniform(-np.pi, np.pi, (n, model.robot.n_joints))


def test_nests_are_where_the_model_has_them(model):
    text, joints = export(model, "urdf").text, angles(model)
    expected = [predict(model, Stops(np.arange(1000), joints), np.full(1000, nest))[0] for nest in (1, 2)]

    for row, configuration in enumerate(joints):
        placed = frames(text, configuration)
        for nest in (1, 2):
            there_m = placed[f"nest_{nest}"][:3, 3]
            np.testing.assert_allclose(there_m, expected[nest - 1][row] / 1000.0, atol=NANOMETRE_M)


def test_a_urdf_of_a_model_reads_back_as_the_same_arm(model):
    found = urdf_from_text("robot.urdf", export(model, "urdf").text.encode())
    joints = angles(model)

    base = (placement_rotation(found.base), placement_translation(found.base))
    chain = forward(nominal_values(found.robot, joints), *base)
    tool = chain.points(placement_translation(found.tip))
    arm = export(model, "urdf").subject.arm
    own_base = (placement_rotation(arm.base), placement_translation(arm.base))
    own = forward(nominal_values(arm.robot, joints), *own_base)

    assert found.tip_link == "tool0"
    np.testing.assert_allclose(tool, own.end_origin, atol=1000.0 * NANOMETRE_M)
    turned = chain.end_rotation @ placement_rotation(found.tip)
    np.testing.assert_allclose(turned, own.end_rotation, atol=1e-12)
    masses = sorted((mass.frame, mass.mass_kg) for mass in found.robot.masses)
    assert masses == sorted((mass.frame, mass.mass_kg) for mass in model.robot.masses)


def test_the_tool_frame_is_turned_as_the_model_turns_it():
    turned = parameters_of("tool", [("tool_rx", 2e-3, "rad"), ("tool_rz", -1e-3, "rad")])
    model = model_of(ROBOTS["irb120"], *turned, tool_rotation_rad=(0.4, -0.3, 1.2))
    joints = angles(model, 5)
    stops = Stops(np.arange(5), joints)
    estimate = identified_estimate(model)

    expected = evaluate(
        estimate.structure, estimate.values, Targets(stops, np.ones(5, dtype=int))
    ).orientation

    text = export(model, "urdf").text
    for row, configuration in enumerate(joints):
        found = frames(text, configuration)["tool0"][:3, :3]
        np.testing.assert_allclose(found, expected[row], atol=1e-12)


def test_every_link_hangs_on_one_joint_and_every_name_is_legal(model):
    model = replace(model, robot=replace(model.robot, name='7 <"ax>s" -- è --->'))
    root = ElementTree.fromstring(export(model, "urdf").text)

    links = [link.get("name") for link in root.findall("link")]
    children = [joint.find("child").get("link") for joint in root.findall("joint")]
    assert len(set(links)) == len(links)
    assert sorted([*children, "world"]) == sorted(links)
    names = [element.get("name") for element in (root, *root)]
    assert all(name.isidentifier() for name in names if name)
    assert root.get("name") == "robot_7_ax_s"
    joints = root.findall("joint")
    assert {(j.get("type"), j.find("axis").get("xyz")) for j in joints if j.find("axis") is not None} <= {
        ("continuous", "0 0 1"),
        ("continuous", "0 0 -1"),
    }


def test_limits_and_masses_stand_where_they_are_known():
    robot = replace(ROBOTS["irb120"], joint_limits=(JointRange(-1.0, 2.0),) * 6)
    root = ElementTree.fromstring(export(geometric(robot), "urdf").text)

    limit = root.find("joint[@name='joint_3']/limit")
    assert (limit.get("lower"), limit.get("upper")) == ("-1.0", "2.0")
    inertial = root.find("link[@name='link_4']/inertial")
    assert inertial.find("mass").get("value") == "5.0"
    assert inertial.find("origin").get("xyz") == "0.0 0.0 -0.1936"
    assert root.find("link[@name='link_3']/inertial") is None


@pytest.mark.parametrize("effect", ["backlash", "thermal_growth", "joint_harmonics", "instrument_scale"])
def test_what_a_urdf_cannot_carry_is_listed_in_it_and_in_the_answer(effect):
    exported = export(extended(ROBOTS["irb120"], effect), "urdf")

    said = [english(sentence) for sentence in exported.remarks]
    count = len(EXTENSIONS[effect])
    assert any(
        line.startswith("Not in the file") and line.endswith(f"(parameters: {count}).") for line in said
    )
    assert all(line in exported.text for line in said if "--" not in line)
    assert exported.subject.left_out == {"compliance": 6, effect: count}


def test_of_a_model_that_is_carried_whole_nothing_is_listed(model):
    said = [english(sentence) for sentence in export(model, "urdf").remarks]

    assert said[0] == "The file contains the whole model."
    assert not any(line.startswith("Not in the file") for line in said)
    assert any("is unknown: the model" in line for line in said)


def test_what_the_loss_comes_to_is_said_where_the_zone_is_known():
    loaded = zoned(extended(ROBOTS["irb120"]))

    plain, fitted = export(loaded, "urdf").subject, export(loaded, "urdf", fitted=True).subject

    assert export(zoned(geometric(ROBOTS["irb120"])), "urdf").subject.error.max_mm < 1e-9
    assert plain.error.mean_mm > 0.1
    assert fitted.error.mean_mm < 0.5 * plain.error.mean_mm
    assert fitted.left_out == plain.left_out == {"compliance": 6}
