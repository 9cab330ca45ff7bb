"""Robots from URDF against a reader of that format that shares nothing with the service."""

import numpy as np
import pytest

from tests.helpers.kinematics.urdf_frames import frames
from truepose.domain.robot import JointRange
from truepose.exchange.errors import InputFileError, UnreadableFileError
from truepose.exchange.robots.named import read_robot_file
from truepose.exchange.robots.urdf_import import urdf_from_text
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation

NANOMETRE_M = 1e-9


def joint(name, parent, child, kind="revolute", origin="", axis='<axis xyz="0 0 1"/>', more=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"<origin {origin}/>{axis}{more}</joint>"
    )


def robot(*joints, links=(), name="arm"):
    names = dict.fromkeys(
        end.split('link="')[1].split('"')[0] for text in joints for end in text.split("<")[2:4]
    )
    bodies = [link for link in names if not any(f'name="{link}"' in text for text in links)]
    links = [*links, *(f'<link name="{link}"/>' for link in bodies)]
    return f'<?xml version="1.0"?>\n<robot name="{name}">\n' + "\n".join([*links, *joints]) + "\n</robot>"


# Axes in every direction, two nearly parallel, one counting backwards, frames that are turned for no reason.
BENT = robot(
    joint("stand", "world", "base", "fixed", 'xyz="0.1 -0.2 0.3" rpy="0.1 0.2 0.3"', ""),
    joint("j1", "base", "l1", "revolute", 'xyz="0 0 0.29" rpy="0 0 0.5"', '<axis xyz="0 0 2"/>'),
    joint("j2", "l1", "l2", "continuous", 'xyz="0.05 0 0" rpy="0 0.3 0"', '<axis xyz="0 1 0"/>'),
    joint("plate", "l2", "plate", "fixed", 'xyz="0 0 0.1" rpy="0 0 0.001"', ""),
    joint("j3", "plate", "l3", "revolute", 'xyz="0 0 0.17"', '<axis xyz="0.0003 -1 0.0004"/>'),
    joint("j4", "l3", "l4", "revolute", 'xyz="0.302 0 0.07"', ""),
    joint("j5", "l4", "l5", "revolute", "", '<axis xyz="0 0 -1"/>'),
    joint("flange", "l5", "tool0", "fixed", 'xyz="0.072 0.01 0" rpy="0 1.5707963267948966 0"', ""),
)


def read(text, **ends):
    return urdf_from_text("arm.urdf", text.encode(), **ends)


def tip_in_base_mm(found, joints):
    """The tip in the base link by the table and what is fixed at its ends."""

    def frame(placement):
        placed = np.eye(4)
        placed[:3, :3], placed[:3, 3] = placement_rotation(placement), placement_translation(placement)
        return placed

    chain, last = nominal_chain(found.robot, joints[None]), np.eye(4)
    last[:3, :3], last[:3, 3] = chain.end_rotation[0], chain.end_origin[0]
    return frame(found.base) @ last @ frame(found.tip)


def test_the_table_of_a_urdf_moves_its_tip_as_the_urdf_does():
    found = read(BENT)

    assert (found.base_link, found.tip_link) == ("world", "tool0")
    for joints in np.random.default_rng(1).uniform(-3.0, 3.0, (200, 5)):
        expected = frames(BENT, joints)["tool0"]
        placed = tip_in_base_mm(found, joints)
        np.testing.assert_allclose(placed[:3, 3] / 1000.0, expected[:3, 3], atol=NANOMETRE_M)
        np.testing.assert_allclose(placed[:3, :3], expected[:3, :3], atol=1e-12)


def test_axes_that_are_parallel_but_for_a_tilt_get_a_beta_and_no_kilometres():
    rows = read(BENT).robot.joints

    assert [k for k, row in enumerate(rows, 1) if row.beta_rad] == [3]
    assert max(abs(row.a_mm) + abs(row.d_mm) for row in rows) < 1000.0
    assert [row.sign for row in rows] == [1, 1, 1, 1, -1]


def test_ends_can_be_chosen():
    found = read(BENT, base="l1", tip="l4")

    assert found.robot.n_joints == 3
    here = np.linalg.inv(frames(BENT, np.zeros(5))["l1"]) @ frames(BENT, [0.0, 0.3, -0.4, 0.5, 0.0])["l4"]
    placed = tip_in_base_mm(found, np.array([0.3, -0.4, 0.5]))
    assert placed[:3, 3] / 1000.0 == pytest.approx(here[:3, 3], abs=NANOMETRE_M)


def test_masses_go_to_the_frame_that_they_move_with_fixed_links_too():
    heavy = (
        '<link name="world"><inertial><mass value="50"/></inertial></link>',
        '<link name="plate"><inertial><origin xyz="0.01 0.02 0.03"/><mass value="2.5"/></inertial></link>',
        '<link name="l2"><inertial><mass value="4"/></inertial></link>',
    )
    text = BENT.replace("\n<", "\n" + "\n".join(heavy) + "\n<", 1)
    for name in ("world", "plate", "l2"):
        text = text.replace(f'<link name="{name}"/>', "")

    found = read(text.replace('<robot name="arm">', "").replace("?>\n", '?>\n<robot name="arm">', 1))

    assert [(mass.frame, mass.mass_kg) for mass in found.robot.masses] == [(2, 4.0), (2, 2.5)]
    chain = nominal_chain(found.robot, np.zeros((1, 5)))
    mass = found.robot.masses[1]
    local = chain.rotation[1, 0] @ mass.centre_of_gravity_mm + chain.origin[1, 0]
    world = placement_rotation(found.base) @ local + placement_translation(found.base)
    expected = frames(BENT, np.zeros(5))["plate"] @ [0.01, 0.02, 0.03, 1.0]
    assert world / 1000.0 == pytest.approx(expected[:3], abs=NANOMETRE_M)


LIMIT = '<limit lower="-1.5" upper="2" effort="1" velocity="1"/>'


def test_limits_are_read_where_every_joint_has_some():
    known = joint("a", "b", "c", more=LIMIT)

    both = robot(known, joint("d", "c", "e", "continuous"))
    one = robot(known, joint("d", "c", "e"))

    assert read(both).robot.joint_limits == (JointRange(-1.5, 2.0), JointRange(-2 * np.pi, 2 * np.pi))
    assert read(one).robot.joint_limits is None


def test_frames_beside_the_tool_are_no_second_tip():
    nests = [joint(f"n{k}", "l1", f"nest_{k}", "fixed", 'xyz="0 0.1 0.2"', "") for k in (1, 2)]

    assert read(robot(joint("a", "b", "l1"), *nests)).tip_link == "l1"
    assert read(robot(joint("a", "b", "l1"), nests[0])).tip_link == "nest_1"


HAND = (joint("left", "l1", "f1", "prismatic"), joint("right", "l1", "f2", "prismatic"))
MIMIC = '<mimic joint="a"/>'


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            robot(joint("a", "b", "c"), joint("d", "x", "c")),
            "'c' has two parent joints, 'a' and 'd': a loop",
        ),
        (robot(joint("a", "b", "c"), joint("d", "c", "b")), "the joints form a loop"),
        (robot(joint("a", "b", "c"), joint("d", "x", "y"), joint("e", "y", "x")), "'x' is in a loop"),
        (robot(joint("a", "b", "c"), joint("d", "x", "y")), "these are two robots"),
        (
            robot(joint("a", "b", "l1"), *HAND),
            "branches into joints 'left' and 'right'; name",
        ),
        (robot(joint("a", "b", "c"), joint("d", "c", "e", "prismatic")), "joint 'd' is prismatic"),
        (robot(joint("a", "b", "c"), joint("d", "c", "e", "floating")), "joint 'd' is floating"),
        (robot(joint("a", "b", "c"), joint("d", "c", "e", more=MIMIC)), "joint 'd' follows joint 'a'"),
        (robot(joint("a", "b", "c", "fixed")), "no revolute joint"),
        (robot(joint("a", "b", "c", axis='<axis xyz="0 0 0"/>')), "line 5: the axis has no direction"),
        (robot(joint("a", "b", "c", origin='xyz="0 0"')), "2 numbers found under xyz where 3 are required"),
        (robot(joint("a", "b", "c", origin='xyz="0 0 nan"')), "'nan' is not a number"),
        (robot(joint("a", "b", "c", origin='rpy="0 0 ${pi}"')), r"\{pi\}' is not a number"),
        (robot(joint("a", "b", "c", origin='xyz="0 0 29000"')), "29000000.0 mm|2.9e\\+07 mm"),
        (robot(joint("a", "b", "c", axis='<axis xyz="1e308 1 0"/>')), "is too large for any quantity"),
        (robot(joint("a", "b", "c", more='<limit lower="1" upper="1"/>')), "is not below the upper limit"),
        (
            robot(joint("a", "b", "c")).replace('<link name="c"/>', ""),
            "link 'c', which does not exist",
        ),
        (robot(joint("a", "b", "c"), joint("a", "c", "d")), "a second joint is called 'a'"),
        (robot(joint("a", "b", "c")).replace('<child link="c"/>', ""), "<joint> needs a <child>"),
        (
            robot(links=['<link name="l"><inertial><mass value="-1"/></inertial></link>']),
            "-1 kg is not plausible",
        ),
        ('<robot name="r" xmlns:xacro="x"><xacro:include filename="f"/></robot>', "this is a xacro file"),
        ("<sdf/>", "begins with <sdf>, not <robot>"),
        (BENT[:300], r"line 12: this is not XML \(unclosed"),
        ("", r"this is not XML \(no element found"),
        ("name = 'arm'", "this is not XML"),
        ('<?xml version="1.0" encoding="banana"?><robot name="r"/>', "line 1: .*its encoding is not known"),
        ('<?xml version="1.0" encoding="shift_jis"?><robot name="r"/>', "its encoding is not known"),
        (robot(joint("a", "b", "c", origin='xyz="0 0 1_0"')), "'1_0' is not a number"),
        ("<robot>" + "<a>" * 200, "nested too deeply"),
        ('<robot name="r">' + "<x/>" * 5000 + "</robot>", "more than any robot"),
    ],
)
def test_what_is_no_serial_arm_is_refused_in_one_sentence(text, sentence):
    with pytest.raises(InputFileError, match=sentence) as refused:
        read(text)

    assert str(refused.value).startswith("arm.urdf")
    assert "\n" not in str(refused.value)


def test_entities_are_not_read():
    bomb = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><robot name="&b;"/>'
    outside = '<!DOCTYPE r [<!ENTITY f SYSTEM "file:///etc/passwd">]><robot name="&f;"/>'

    for text in (bomb, outside):
        with pytest.raises(UnreadableFileError, match="declares a document type"):
            read(text)


@pytest.mark.parametrize("ends", [{"base": "nowhere"}, {"tip": "nowhere"}])
def test_an_end_that_is_not_there_is_refused_with_those_that_are(ends):
    with pytest.raises(InputFileError, match=r"no link 'nowhere'; it has .*tool0"):
        read(BENT, **ends)


def test_a_tip_that_does_not_hang_on_the_base_is_refused():
    with pytest.raises(InputFileError, match="link 'l1' is not a descendant of link 'l4'"):
        read(BENT, base="l4", tip="l1")


def test_a_hand_can_be_left_off_by_naming_the_tip_behind_the_file(tmp_path):
    (tmp_path / "arm.urdf").write_text(robot(joint("a", "b", "l1"), *HAND))

    found = read_robot_file(tmp_path / "arm.urdf#l1")

    assert found.robot.n_joints == 1
    assert found.robot.source == "URDF, arm.urdf"


def test_a_sign_in_the_name_of_a_file_is_part_of_it(tmp_path):
    (tmp_path / "arm#2.urdf").write_text(robot(joint("a", "b", "l1"), *HAND))

    assert read_robot_file(tmp_path / "arm#2.urdf#l1").robot.n_joints == 1
    with pytest.raises(InputFileError, match="the arm branches"):
        read_robot_file(tmp_path / "arm#2.urdf")


def test_a_file_of_no_known_kind_is_refused_with_those_that_are(tmp_path):
    with pytest.raises(UnreadableFileError, match=r"ends in .toml, .urdf"):
        read_robot_file(tmp_path / "arm.xml")
