"""A URDF where a robot file is taken: cells and campaigns in memory."""

import numpy as np

import truepose as tp
from truepose.exchange.cells.file import read_cell

URDF = """<robot name="elbow">
<link name="base"/><link name="a"/><link name="b"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.3"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="0" velocity="0"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0 0"
rpy="1.5707963267948966 0 0"/>
<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="0" velocity="0"/></joint>
</robot>"""
ROBOT_DEVICE = '[[device]]\nname = "robot"\ndriver = "abb_open_abb"\nhost = "192.168.0.1"\n'


def test_a_campaign_takes_its_robot_from_a_urdf(tmp_path):
    (tmp_path / "elbow.urdf").write_text(URDF)
    points = {"config": [1, 2], "joints_deg": [[0.0, 10.0], [20.0, 30.0]]}
    points |= {"nest": [1, 1], "position_mm": np.zeros((2, 3)), "u_mm": [0.01, 0.01]}

    campaign = tp.read_campaign(points, robot=str(tmp_path / "elbow.urdf"))

    robot = campaign.data.robot
    assert [round(row.d_mm) for row in robot.joints] == [300, 0]
    assert round(robot.joints[1].a_mm) == 100
    assert robot.joint_limits[1].upper_rad == 2.0


def test_a_cell_file_names_a_urdf_beside_it(tmp_path):
    (tmp_path / "elbow.urdf").write_text(URDF)
    (tmp_path / "cell.toml").write_text(f'robot = "elbow.urdf"\n{ROBOT_DEVICE}')

    cell = read_cell(tmp_path / "cell.toml")

    assert cell.robot.name == "elbow"
    assert cell.nests == ()
