"""Points beside the joint angles at which they were read."""

import numpy as np
import pytest

from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.point_list import NamedPoint
from truepose.exchange.campaigns.points_with_joints import Stated, import_points, join_tables
from truepose.exchange.errors import BadValueError, MissingEntryError, UnreadableFileError

JOINTS = "config,q1_deg,q2_deg\n1,10,20\n2,11,21\n3,12,22\n"


def points(*names, uncertainty=None):
    return [NamedPoint(name, (k + 0.5, 0.0, 0.0), uncertainty, k) for k, name in enumerate(names, start=1)]


def join(listed, table=JOINTS, **options):
    return join_tables(listed, "joints.csv", table.encode(), **({"u_mm": 0.02} | options))


def test_points_go_to_the_configuration_whose_number_ends_their_name_in_any_order():
    found = join(points("P003", "P001", "P002"))

    assert found.columns["config"].tolist() == [1.0, 2.0, 3.0]
    assert found.columns["x_mm"].tolist() == [2.5, 3.5, 1.5]
    assert found.columns["q2_deg"].tolist() == [20.0, 21.0, 22.0]
    assert found.columns["u_mm"].tolist() == [0.02] * 3
    assert (found.points_alone, found.rows_alone) == ((), ())


def test_what_has_no_other_half_is_left_out_and_named():
    found = join(points("P1", "P3", "P9", "origin"))

    assert found.columns["config"].tolist() == [1.0, 3.0]
    assert found.points_alone == ("P9", "origin")
    assert found.rows_alone == (3,)


def test_a_pattern_says_configuration_and_nest():
    table = "config,nest,q1_deg\n1,1,10\n1,2,10\n2,1,11\n"

    found = join(points("C01_N2 a", "C02_N1 b", "C01_N1 c"), table, names="C{config}_N{nest}*")

    assert found.columns["x_mm"].tolist() == [3.5, 1.5, 2.5]


def test_a_column_of_names_outranks_every_pattern():
    table = "point,config,q1_deg\nupper left,7,10\n0002,8,11\n"

    found = join(points("2", "upper left"), table, names="nothing {config}")

    assert found.columns["config"].tolist() == [7.0, 8.0]
    assert found.columns["x_mm"].tolist() == [2.5, 1.5]
    assert "point" not in found.columns


def test_own_uncertainties_count_as_one_for_all_axes_unless_one_is_stated():
    own = points("1", uncertainty=(0.01, 0.02, 0.02))

    assert join(own, u_mm=None).columns["u_mm"] == pytest.approx([np.sqrt(3.0) * 0.01])
    assert join(own, u_mm=0.5).columns["u_mm"].tolist() == [0.5]


def test_an_empty_cell_is_left_to_the_format():
    assert np.isnan(join(points("1"), "config,q1_deg,time_s\n1,10,\n").columns["time_s"][0])


@pytest.mark.parametrize(
    ("listed", "table", "options", "error", "said"),
    [
        (points("1"), JOINTS, {"u_mm": None}, MissingEntryError, "no uncertainties"),
        (points("P7"), JOINTS, {}, MissingEntryError, "points are called 'P7', rows have config 1, 2, 3"),
        (points("1"), "q1_deg\n10\n", {}, MissingEntryError, "column config is required"),
        (points("1"), "config,q1_deg\n1,ten\n", {}, BadValueError, "line 2, column q1_deg: 'ten'"),
        (points("1"), "config,q1_deg\n1,1_0\n", {}, BadValueError, "line 2, column q1_deg: '1_0'"),
        (points("1"), "config,q1_deg\n1,inf\n", {}, BadValueError, "line 2, column q1_deg: 'inf'"),
        (points("1"), "config,q1_deg,q1_deg\n1,1,2\n", {}, BadValueError, "the column appears twice"),
        (points("1"), "config,q1_deg\n1\n", {}, UnreadableFileError, "line 2: 1 cells found where"),
        (points("1"), "\nq1_deg\n10\n", {}, MissingEntryError, "line 2: column config is required"),
        (points("1"), JOINTS, {"names": "P*"}, ConfigurationError, "where {config} is in"),
    ],
)
def test_what_cannot_be_joined_is_one_sentence(listed, table, options, error, said):
    with pytest.raises(error) as refused:
        join(listed, table, **options)

    assert said in str(refused.value)


def test_a_number_of_thousands_of_digits_names_a_configuration_that_is_not_there():
    assert join(points("1", "7" * 5000)).points_alone == ("7" * 5000,)


@pytest.mark.parametrize(
    ("nest", "said"),
    [
        ("3e6", "'3000000.0' must be one of the tool nests: 1"),
        ("", "the cell is empty"),
        ("-1", "must be one of"),
    ],
)
def test_a_nest_that_nobody_has_is_refused_and_costs_nothing(tmp_path, nest, said):
    (tmp_path / "points.txt").write_text("P1 1.5 2.5 3.5\n")
    angles = ",".join(f"q{k}_deg" for k in range(1, 7))
    (tmp_path / "joints.csv").write_text(f"config,nest,{angles}\n1,{nest},1,2,3,4,5,6\n")
    stated = Stated("abb-irb-120", unit="mm", u_mm=0.02)

    with pytest.raises(BadValueError, match=said) as refused:
        import_points(tmp_path / "points.txt", tmp_path / "joints.csv", stated)

    place = refused.value.file, refused.value.line, refused.value.column
    assert place == ("joints.csv", 2, "nest")
