"""Rows for a command: the format to the letter, any other table as the import understands it."""

import numpy as np
import pytest

from truepose.exchange.errors import InputFileError
from truepose.exchange.import_wizard.single_table import (
    read_points_to_predict,
    read_validation_file,
    single_table,
)

HEAD = "Pose;A1 [deg];A2 [deg];A3 [deg];X [m];Y [m];Z [m]"
ROWS = ["1;10,5;20;-30;0,3001;0,0205;0,4", "2;12;22,25;-32;0,31;0,025;0,41"]
NESTS = (1, 2)


def laid(tmp_path, lines, encoding="utf-8"):
    file = tmp_path / "points.csv"
    file.write_bytes("\n".join(lines).encode(encoding))
    return file


@pytest.mark.parametrize(
    ("lines", "encoding"),
    [
        ([HEAD, *ROWS], "utf-8"),
        (["measured in cell 3", "", HEAD, *ROWS], "latin-1"),
        (["Pose;A1;A2;A3;X;Y;Z", ";deg;deg;deg;m;m;m", *ROWS], "utf-16"),
        ([line.replace(";", "\t") for line in (HEAD, *ROWS)], "utf-8"),
    ],
)
def test_headings_units_and_commas_of_other_programs_are_read(tmp_path, lines, encoding):
    read = read_validation_file(laid(tmp_path, lines, encoding), 3, NESTS, u_mm=0.02).readings

    assert np.rad2deg(read.stops.joints_rad) == pytest.approx(np.array([[10.5, 20, -30], [12, 22.25, -32]]))
    assert read.position_mm == pytest.approx(np.array([[300.1, 20.5, 400], [310, 25, 410]]))
    assert read.standard_uncertainty_mm.tolist() == [0.02, 0.02]
    assert (read.stops.config.tolist(), read.nest.tolist()) == ([1, 2], [1, 1])


def test_a_table_of_the_format_is_read_to_the_letter():
    data = b"config,q1_deg,x [m]\n1,2,3\n"

    assert single_table("points.csv", data).data is data


def test_readings_whose_uncertainty_nobody_says_are_refused(tmp_path):
    with pytest.raises(InputFileError, match=r"points\.csv: no column has the uncertainty of the readings"):
        read_validation_file(laid(tmp_path, [HEAD, *ROWS]), 3, NESTS)


def test_a_column_goes_before_what_is_said(tmp_path):
    lines = [f"{HEAD};u [mm]", *(f"{row};0,05" for row in ROWS)]

    read = read_validation_file(laid(tmp_path, lines), 3, NESTS, u_mm=0.02).readings

    assert read.standard_uncertainty_mm.tolist() == [0.05, 0.05]


def test_stops_to_predict_need_no_readings(tmp_path):
    lines = ["J1 (rad),J2 (rad),J3 (rad)", "0.1,0.2,-0.3", "0.2,0.4,-0.6"]

    read = read_points_to_predict(laid(tmp_path, lines), 3, NESTS)

    assert read.stops.joints_rad == pytest.approx(np.array([[0.1, 0.2, -0.3], [0.2, 0.4, -0.6]]))
    assert read.nest is None


def test_a_fault_is_named_by_the_line_of_the_file(tmp_path):
    lines = [f"{HEAD};Nest", *(f"{row};{nest}" for row, nest in zip(ROWS, (1, 7), strict=True))]

    with pytest.raises(InputFileError, match=r"points\.csv, line 3.*must be one of the tool nests: 1, 2"):
        read_validation_file(laid(tmp_path, lines), 3, NESTS, u_mm=0.02)


def test_what_a_column_was_taken_for_is_told(tmp_path):
    table = single_table("points.csv", laid(tmp_path, ["Pose;A1;A2;A3;X;Y;Z", *ROWS]).read_bytes())

    told = [dict(one.values) for one in table.remarks]
    assert ("A1", "q1_deg", "deg") in [(one["heading"], one["column"], one["unit"]) for one in told]


def test_a_table_without_joints_is_refused_by_the_format(tmp_path):
    with pytest.raises(InputFileError, match="line 1: the columns are separated by semicolons"):
        read_validation_file(laid(tmp_path, ["X;Y;Z", "1;2;3"]), 3, NESTS, u_mm=0.02)
