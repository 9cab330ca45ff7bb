"""`calibrated_kinematics.yaml` against published nominal values, and a URDF made of its numbers."""

import numpy as np
import pytest
import yaml

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from tests.helpers.kinematics.urdf_frames import frames
from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import InputFileError
from truepose.exchange.models.exports import export
from truepose.exchange.robots.named import load_robot, read_robot_file
from truepose.exchange.robots.ros_calibrated_kinematics import LINKS, kinematics_from_text
from truepose.kinematics.chain import nominal_chain

UR10 = load_robot("universal-robots-ur10")
# The maker's nominal UR10 as its description has it [m, rad]; wrist 3 by Euler angles of the other kind.
PUBLISHED = {
    "shoulder": (0, 0, 0.1273, 0, 0, 0),
    "upper_arm": (0, 0, 0, 1.570796327, 0, 0),
    "forearm": (-0.612, 0, 0, 0, 0, 0),
    "wrist_1": (-0.5723, 0, 0.163941, 0, 0, 0),
    "wrist_2": (0, -0.1157, -2.373046667922381e-11, 1.570796327, 0, 0),
    "wrist_3": (0, 0.0922, -1.891053610911353e-11, 1.570796326589793, 3.141592653589793, 3.141592653589793),
}
NAMES = ("x", "y", "z", "roll", "pitch", "yaw")


def text_of(origins, **more):
    links = {link: dict(zip(NAMES, origin, strict=True)) for link, origin in origins.items()}
    return yaml.safe_dump({"kinematics": links | {"hash": "calib_12788084448423163542"} | more})


def as_urdf(origins):
    """The same numbers where the description of the arm puts them."""
    joints = "".join(
        f'<joint name="{link}" type="revolute"><parent link="{before}"/><child link="{link}"/>'
        f'<origin xyz="{" ".join(map(repr, map(float, origin[:3])))}" '
        f'rpy="{" ".join(map(repr, map(float, origin[3:])))}"/><axis xyz="0 0 1"/></joint>'
        for before, (link, origin) in zip(("base", *LINKS), origins.items(), strict=False)
    )
    return (
        f"<robot name='ur'>{''.join(f'<link name={link!r}/>' for link in ('base', *LINKS))}{joints}</robot>"
    )


def origins_of(text):
    kinematics = yaml.safe_load(text)["kinematics"]
    return {link: tuple(kinematics[link][name] for name in NAMES) for link in LINKS}


def test_the_published_arm_is_the_shipped_one():
    robot = kinematics_from_text("default_kinematics.yaml", text_of(PUBLISHED).encode())

    joints = np.random.default_rng(1).uniform(-3.0, 3.0, (100, 6))
    found, shipped = nominal_chain(robot, joints), nominal_chain(UR10, joints)
    # 1.570796327 stands for a right angle: 2e-10 rad at 1.3 m.
    np.testing.assert_allclose(found.end_origin, shipped.end_origin, atol=1e-6)
    assert "calib_12788084448423163542" in robot.name


def test_a_calibrated_arm_moves_as_its_description_does():
    rng = np.random.default_rng(2)
    origins = {link: tuple(np.array(o) + 1e-3 * rng.standard_normal(6)) for link, o in PUBLISHED.items()}
    robot = kinematics_from_text(
        "ur.yaml", text_of({k: tuple(map(float, o)) for k, o in origins.items()}).encode()
    )

    home = nominal_chain(robot, np.zeros((1, 6)))
    urdf = as_urdf(origins)
    start = frames(urdf, np.zeros(6))["wrist_3"]
    for joints in rng.uniform(-3.0, 3.0, (100, 6)):
        chain = nominal_chain(robot, joints[None])
        # The table's base and flange frame lie elsewhere on their axes: compare what the motion did.
        moved = chain.end_rotation[0] @ home.end_rotation[0].T
        there = frames(urdf, joints)["wrist_3"]
        turn = np.trace(there[:3, :3] @ start[:3, :3].T)
        assert np.trace(moved) == pytest.approx(turn, abs=1e-9)
        far = np.linalg.norm(there[:3, 3] - start[:3, 3])
        assert np.linalg.norm(chain.end_origin - home.end_origin) / 1000.0 == pytest.approx(far, abs=1e-9)
    assert all(abs(row.d_mm) < 1000.0 for row in robot.joints)


def model():
    return model_of(UR10, *(p for p in plain_parameters(UR10) if p.effect != "compliance"))


def test_an_identified_arm_is_written_as_its_description_takes_it():
    exported = export(model(), "ros")

    text, arm = exported.text, exported.subject.arm
    joints = np.random.default_rng(3).uniform(-3.0, 3.0, (1000, 6))
    chain = nominal_chain(arm.robot, joints)
    urdf = as_urdf(origins_of(text))
    for row, configuration in enumerate(joints):
        there = frames(urdf, configuration)["wrist_3"]
        np.testing.assert_allclose(there[:3, 3], chain.end_origin[row] / 1000.0, atol=1e-9)
        np.testing.assert_allclose(there[:3, :3], chain.end_rotation[row], atol=1e-12)


def test_the_hash_goes_with_the_numbers_and_is_no_controllers():
    first, second = (
        yaml.safe_load(export(m, "ros").text)["kinematics"]["hash"] for m in (model(), model_of(UR10))
    )

    assert first != second
    assert first.startswith("truepose_")


def test_an_arm_of_another_structure_is_refused():
    with pytest.raises(
        ConfigurationError, match="ABB IRB 120 does not have the axes of a Universal Robots arm"
    ):
        export(model_of(IRB_120), "ros")


def test_a_file_is_taken_where_a_robot_is(tmp_path):
    (tmp_path / "arm.yaml").write_text(export(model(), "ros").text)

    assert read_robot_file(tmp_path / "arm.yaml").robot.n_joints == 6


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (text_of(PUBLISHED).replace("wrist_2", "wrist_9"), "key kinematics: key wrist_2 is missing"),
        (text_of({**PUBLISHED, "forearm": (float("nan"),) * 6}), "key kinematics.forearm.x: .*not finite"),
        (text_of({**PUBLISHED, "forearm": ("far",) * 6}), "key kinematics.forearm.x: 'far' is not a number"),
        (
            text_of({**PUBLISHED, "forearm": (2000,) * 6}),
            "key kinematics.forearm: 2e\\+06 mm is not a plausible length",
        ),
        ("kinematics: [1, 2", "line 1: this is not YAML"),
        ("kinematics: !!python/object/apply:os.system [ls]", "this is not YAML"),
        ("- 1", "an object with keys is required"),
        ("[" * 1000, "this is not YAML"),
        ("a: &a [*a]", "line 1: this is not YAML: it has aliases or is nested"),
        ("a: " + "[" * 400 + "]" * 400, "line 1: this is not YAML: it has aliases or is nested"),
        (text_of({**PUBLISHED, "forearm": ("1_0",) * 6}), "key kinematics.forearm.x: '1_0' is not a number"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_key(text, sentence):
    with pytest.raises(InputFileError, match=sentence):
        kinematics_from_text("ur.yaml", text.encode())


def test_numbers_without_a_point_before_the_exponent_are_numbers():
    text = text_of(PUBLISHED).replace("x: -0.612", "x: -612e-3")

    robot = kinematics_from_text("ur.yaml", text.encode())

    assert "-612e-3" in text
    assert robot.joints[2].a_mm == pytest.approx(-612.0)
