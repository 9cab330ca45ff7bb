"""Tables as notebooks have them become the columns of the file format, or say which of them cannot."""

import numpy as np
import pytest

from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import BadValueError, MissingFileError
from truepose.notebook.inputs import columns_of, named_data, readings_given


def test_blocks_stand_for_columns():
    table = {
        "joints_deg": np.arange(6.0).reshape(3, 2),
        "position_mm": np.ones((3, 3)),
        "dir": np.ones((3, 2)),
    }

    columns = columns_of(table, "points")

    assert list(columns) == ["q1_deg", "q2_deg", "x_mm", "y_mm", "z_mm", "dir1", "dir2"]
    assert columns["q2_deg"].tolist() == [1.0, 3.0, 5.0]


@pytest.mark.parametrize("table", [{"joints_rad": [[np.pi, 0.0]]}, {"q1_rad": [np.pi], "q2_rad": [0.0]}])
def test_joints_in_radians_are_turned_into_degrees(table):
    columns = columns_of(table, "points")

    assert {name: values.tolist() for name, values in columns.items()} == {"q1_deg": [180.0], "q2_deg": [0.0]}


def test_only_joints_may_be_in_radians():
    assert list(columns_of({"qx_rad": [1.0], "tilt_rad": [1.0]}, "points")) == ["qx_rad", "tilt_rad"]


def test_one_value_holds_for_every_row():
    columns = columns_of({"u_mm": 0.015, "config": [1, 2, 3]}, "points")

    assert columns["u_mm"].tolist() == [0.015] * 3


def test_a_structured_array_is_a_table():
    table = np.array([(1, 0.5), (2, 0.7)], dtype=[("config", "i8"), ("u_mm", "f8")])

    assert {name: values.tolist() for name, values in columns_of(table, "points").items()} == {
        "config": [1, 2],
        "u_mm": [0.5, 0.7],
    }


def test_what_a_frame_does_not_know_is_unknown():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"attachment": pandas.array([1, None], dtype="Int64"), "kind": ["base", None]})

    columns = columns_of(frame, "points")

    assert np.isnan(columns["attachment"][1])
    assert columns["kind"].tolist()[0] == "base"


@pytest.mark.parametrize(
    ("table", "error", "sentence"),
    [
        (
            [1, 2],
            ConfigurationError,
            "points: a list is not a table; give a DataFrame or a mapping of names to",
        ),
        (
            {"a": [1, 2], "b": [1]},
            BadValueError,
            "column b: the column has length 1; other columns have length 2.",
        ),
        (
            {"a": [[1, 2]]},
            BadValueError,
            "points, column a: the values have 2 dimensions; a column must have one.",
        ),
        (
            {"joints_deg": [1.0]},
            BadValueError,
            "the shape is (1,); (n, joints) is required.",
        ),
        ({"position_mm": [[1.0, 2.0]]}, BadValueError, "the shape is (1, 2); (n, 3) is required."),
        (
            {"q1_deg": [1.0], "joints_deg": [[1.0]]},
            BadValueError,
            "column q1_deg: the column appears twice",
        ),
        (
            {"q1_deg": [1.0], "q1_rad": [1.0]},
            BadValueError,
            "column q1_deg: the column appears twice",
        ),
    ],
)
def test_what_is_no_table_is_refused(table, error, sentence):
    with pytest.raises(error) as refused:
        columns_of(table, "points")

    assert sentence in str(refused.value)


def test_a_column_that_a_frame_has_twice_is_refused():
    pandas = pytest.importorskip("pandas")

    with pytest.raises(BadValueError, match=r"points, column a: the column appears twice; keep one\."):
        columns_of(pandas.DataFrame([[1, 2]], columns=["a", "a"]), "points")


def test_the_name_of_a_file_is_kept(tmp_path):
    (tmp_path / "held-out.csv").write_text("config\n1\n")

    assert named_data(tmp_path / "held-out.csv", "points") == ("held-out.csv", b"config\n1\n")
    with pytest.raises(MissingFileError, match=r"absent\.csv: there is no such file\."):
        named_data(str(tmp_path / "absent.csv"), "points")


def test_headings_of_other_programs_are_understood_as_the_browser_does():
    angles = {"Pose": [1, 2], "A1 [rad]": [0.5, np.pi], "A2 [deg]": [1.0, 2.0]}
    table = angles | {f"{axis} [m]": [0.3, np.nan] for axis in "XYZ"}

    found = readings_given(table, "points")

    assert isinstance(found.data, dict)
    assert found.data["q1_deg"] == pytest.approx(np.rad2deg([0.5, np.pi]))
    assert found.data["x_mm"] == pytest.approx([300.0, np.nan], nan_ok=True)
    assert found.assumed >= {"nest"}


def test_what_has_no_joints_is_left_as_it_is():
    assert list(readings_given({"X [m]": [0.3]}, "points").data) == ["X [m]"]
