"""Files of keep-out volumes: what they say, and what is refused with its place."""

import numpy as np
import pytest

from tests.helpers.checkout import CHECKOUT
from truepose.domain.cell import Box, Cylinder, HalfSpace, KeepOuts
from truepose.exchange.cells.file import read_cell
from truepose.exchange.cells.volumes import read_keep_out_file
from truepose.exchange.errors import InputFileError
from truepose.storage.documents import from_document, to_document

BOX = '[[keep_out]]\nname = "conveyor"\nx_mm = [400, 900]\ny_mm = [250, 500]\nz_mm = [0, 350]\n'
POST = '[[keep_out]]\nname = "post"\nfrom_mm = [300, -400, 0]\nto_mm = [300, -400, 900]\nradius_mm = 40\n'
WALL = '[[keep_out]]\nname = "wall"\npoint_mm = [0, 600, 0]\noutward = [0, -1, 0]\n'
READ = KeepOuts(
    (Box("conveyor", (400.0, 250.0, 0.0), (900.0, 500.0, 350.0)),),
    (Cylinder("post", (300.0, -400.0, 0.0), (300.0, -400.0, 900.0), 40.0),),
    (HalfSpace("wall", (0.0, 600.0, 0.0), (0.0, -1.0, 0.0)),),
)


def written(folder, text, name="keep-outs.toml"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_box_a_cylinder_and_a_half_space(tmp_path):
    assert read_keep_out_file(written(tmp_path, WALL + BOX + POST)) == READ


def test_the_example_has_one_of_each_kind():
    read = read_keep_out_file(CHECKOUT / "docs" / "examples" / "keep-out.toml")

    assert read.names == ("conveyor", "lamp post", "wall")


def test_a_box_as_json(tmp_path):
    text = '{"keep_out": [{"name": "b", "x_mm": [1, 2], "y_mm": [3, 4], "z_mm": [5, 6]}]}'

    assert read_keep_out_file(written(tmp_path, text, "k.json")).names == ("b",)


def test_a_cell_file_has_them_under_its_limits(tmp_path):
    sections = (BOX + POST + WALL).replace("[[keep_out]]", "[[limits.keep_out]]")
    cell = read_cell(written(tmp_path, '[simulated]\nscenario = "irb120-tilted"\n' + sections, "cell.toml"))

    assert cell.limits.keep_outs == READ


@pytest.mark.parametrize(("said", "meant"), [("", None), ("seen_within_deg = 15", np.radians(15.0))])
def test_a_cell_file_says_within_which_angle_the_artefact_is_seen(tmp_path, said, meant):
    text = f'[simulated]\nscenario = "irb120-tilted"\n[limits]\n{said}\n'

    assert read_cell(written(tmp_path, text, "cell.toml")).limits.seen_within_rad == meant


def test_an_angle_that_is_no_cone_is_refused(tmp_path):
    text = '[simulated]\nscenario = "irb120-tilted"\n[limits]\nseen_within_deg = 120\n'

    with pytest.raises(InputFileError, match="is not a valid cone"):
        read_cell(written(tmp_path, text, "cell.toml"))


def test_a_stored_cell_keeps_them():
    assert from_document(KeepOuts, to_document(READ)) == READ


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "keep_out"),
        (BOX + BOX, "two keep-out volumes are called 'conveyor'"),
        (BOX.replace("[400, 900]", "[900, 400]"), "x_mm"),
        (BOX.replace("[400, 900]", "[400, 400]"), "x_mm"),
        (BOX.replace('name = "conveyor"\n', ""), "name"),
        (BOX.replace("z_mm = [0, 350]\n", ""), "give all keys of one"),
        (BOX + "radius_mm = 3\n", "give all keys of one"),
        (POST.replace("radius_mm = 40", "radius_mm = 0"), "radius_mm"),
        (POST.replace("to_mm = [300, -400, 900]", "to_mm = [300, -400, 0]"), "ends where it begins"),
        (WALL.replace("[0, -1, 0]", "[0, 0, 0]"), "the vector is zero"),
        (BOX + "[floor]\nz_mm = 3\n", "floor"),
    ],
)
def test_what_is_no_volume_is_refused_with_its_place(tmp_path, text, place):
    with pytest.raises(InputFileError, match=place):
        read_keep_out_file(written(tmp_path, text))
