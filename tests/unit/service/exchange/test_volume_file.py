"""Files of work volumes: what they say, and what is refused with its place."""

import numpy as np
import pytest

from tests.helpers.checkout import CHECKOUT
from truepose.exchange.cells.volumes import read_volume
from truepose.exchange.errors import InputFileError, MissingEntryError

BOX = "[box]\nx_mm = [300, 600]\ny_mm = [-200, 200]\nz_mm = [100, 400]\n"


def written(folder, text, name="volume.toml"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_box_and_ranges_of_joints(tmp_path):
    joints = f"[joints]\nranges_deg = {[[-90, 90]] * 6}\n"

    volume = read_volume(written(tmp_path, BOX + joints), 6)

    assert volume.box_mm == ((300.0, 600.0), (-200.0, 200.0), (100.0, 400.0))
    assert [limit.upper_rad for limit in volume.ranges] == pytest.approx([np.pi / 2] * 6)


def test_the_example_is_a_box_and_ranges_of_joints():
    volume = read_volume(CHECKOUT / "docs" / "examples" / "work-volume.toml", 6)

    assert volume.box_mm == ((300.0, 600.0), (-200.0, 200.0), (100.0, 400.0))
    assert len(volume.ranges) == 6


def test_a_box_alone_as_json(tmp_path):
    text = '{"box": {"x_mm": [1, 2], "y_mm": [3, 4], "z_mm": [5, 6]}}'

    volume = read_volume(written(tmp_path, text, "volume.json"), 6)

    assert volume.box_mm == ((1.0, 2.0), (3.0, 4.0), (5.0, 6.0))
    assert volume.ranges is None


def test_a_file_that_limits_nothing_is_refused(tmp_path):
    with pytest.raises(MissingEntryError, match=r"volume\.toml.*give at least one"):
        read_volume(written(tmp_path, ""), 6)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (BOX.replace("[300, 600]", "[600, 300]"), "x_mm"),
        (BOX.replace("[300, 600]", "[600]"), "x_mm"),
        (BOX.replace("z_mm", "height"), "z_mm"),
        ("[joints]\nranges_deg = [[-90, 90]]\n", "ranges_deg"),
        (BOX + "[sphere]\nradius_mm = 3\n", "sphere"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_key(tmp_path, text, place):
    with pytest.raises(InputFileError, match=place):
        read_volume(written(tmp_path, text), 6)
