"""A cell before a camera: where the artefact's centre is, how exactly it is read, what is refused."""

import re

import numpy as np
import pytest

from truepose.exchange.cells.file import read_cell, reads_poses, simulated_cell
from truepose.exchange.errors import BadValueError
from truepose.kinematics.poses import pose_uncertainty
from truepose.planning.workspace.space import space_to_measure

FLAT, SPATIAL = "irb120-camera", "irb120-camera-spatial"
CAMERA = """
[camera]
position_mm = [2200.0, 100.0, 900.0]
looks_at_mm = [300.0, 0.0, 300.0]
reading_u_mm = 0.06
artefact_u_mm = 0.02
seen_within_deg = 12.0
"""
ROBOT = 'robot = "abb-irb-120"\n'
DEVICE = '[[device]]\nname = "camera"\ndriver = "ndi_polaris"\nhost = "192.168.0.9"\ntool_file = "a.rom"\n'


def read(folder, text):
    path = folder / "cell.toml"
    path.write_text(text, encoding="utf-8")
    return read_cell(path)


def test_the_centre_of_the_artefact_is_one_more_nest_and_poses_are_told_there():
    cell = simulated_cell(FLAT, 1)
    nests = np.array([nest.centre_mm for nest in cell.nests])

    known = pose_uncertainty(nests[:3], 0.045)

    assert nests[3] == pytest.approx(nests[:3].mean(axis=0))
    assert (cell.camera.nest, cell.camera.position_u_mm) == (4, pytest.approx(known.position_mm))
    assert cell.camera.rotation_u_rad == pytest.approx(known.rotation_rad)
    assert cell.nests[3].standard_uncertainty_mm == pytest.approx(0.04 * np.sqrt(0.5))  # by hand: / sqrt(2)
    assert cell.fixed_nests == ()


def test_a_flat_artefact_faces_along_its_normal_and_a_spatial_one_everywhere():
    flat, spatial = simulated_cell(FLAT, 1), simulated_cell(SPATIAL, 1)

    assert np.linalg.norm(flat.nests[3].facing) == pytest.approx(1.0)
    assert flat.limits.seen_within_rad == pytest.approx(np.radians(14.0))
    assert (spatial.nests[3].facing, spatial.nests[0].centre_mm) == (None, (45.0, 0.0, 150.0))


def test_only_the_centre_is_read():
    assert space_to_measure(simulated_cell(FLAT, 1), None).camera.nest == 4


def test_the_tracker_of_other_scenarios_stands_where_it_stood():
    cell = simulated_cell("irb120-tilted", 1)

    assert cell.camera is None
    assert (len(cell.nests), len(cell.fixed_nests)) == (3, 3)


@pytest.mark.parametrize(
    ("scenario", "poses"),
    [
        ("irb120-camera", True),
        ("my/irb120-camera-tall.toml", True),
        ("irb120-tilted", False),
        ("nobody", False),
    ],
)
def test_a_scenario_says_by_its_name_whether_a_camera_reads_poses(scenario, poses):
    assert reads_poses(scenario) is poses


def test_a_real_cell_describes_its_camera(tmp_path):
    cell = read(tmp_path, ROBOT + CAMERA + DEVICE)

    assert cell.camera.position_mm == cell.tracker_position_mm == (2200.0, 100.0, 900.0)
    assert cell.camera.artefact_rotation_u_rad == pytest.approx(cell.camera.rotation_u_rad / 3.0)
    assert not cell.camera.upright
    assert read(tmp_path, ROBOT + CAMERA + "upright = true\n" + DEVICE).camera.upright


@pytest.mark.parametrize(
    ("was", "becomes", "said"),
    [
        ("looks_at_mm = [300.0, 0.0, 300.0]", "looks_at_mm = [2200.0, 100.0, 0.0]", "straight up or down"),
        ("reading_u_mm = 0.06", "reading_u_mm = 0.0", "reading_u_mm"),
        ("seen_within_deg = 12.0", "seen_within_deg = 95.0", "not a valid cone"),
        ("artefact_u_mm = 0.02", "artefact_mm = 0.02", "artefact_mm"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path, was, becomes, said):
    with pytest.raises(BadValueError, match=re.escape(said)):
        read(tmp_path, ROBOT + CAMERA.replace(was, becomes) + DEVICE)


@pytest.mark.parametrize(
    ("nests", "said"),
    [
        ([(0, 0, 100), (50, 0, 100)], "needs 3 tool nests"),
        ([(0, 0, 100), (50, 0, 100), (100, 0, 100)], "on a line"),
    ],
)
def test_nests_that_tell_no_pose_are_refused(tmp_path, nests, said):
    tools = "".join(f"[[tool_nest]]\ncentre_mm = {list(map(float, nest))}\nu_mm = 0.002\n" for nest in nests)

    with pytest.raises(BadValueError, match=said):
        read(tmp_path, ROBOT + CAMERA + tools + DEVICE)
