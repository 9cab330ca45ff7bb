"""Lists of points as metrology programs write them."""

import pytest

from truepose.exchange.campaigns.point_list import read_point_list
from truepose.exchange.errors import BadValueError, MissingEntryError, UnreadableFileError, WrongUnitError


def read(text, unit="mm"):
    return read_point_list("points.txt", text.encode(), unit)


def told(text, unit="mm"):
    return [(point.name, point.position_mm) for point in read(text, unit)]


TWO = [("P1", (1.5, -2.0, 3.0)), ("P2", (4.0, 5.0, 6.25))]


@pytest.mark.parametrize(
    "text",
    [
        "P1 1.5 -2 3\nP2 4 5 6.25\n",
        "P1\t1.5\t-2\t3\nP2\t4\t5\t6.25\n",
        "P1, 1.5, -2.0, 3.0\r\nP2, 4., 5.0, 6.25\r\n",
        "P1;1,5;-2,0;3,0\nP2;4,0;5,0;6,25\n",
        "// a comment\n\n# another\nA::G P1 1.5 -2 3 0.01 0.02 0.03\nA::G P2 4 5 6.25 0.01 0.02 0.03\n",
        'A "Calib Points" P1 1.5 -2 3\nA "Calib Points" P2 4 5 6.25\n',
        "A,Calib Points,P1,1.5,-2,3\nA,Calib Points,P2,4,5,6.25\n",
        "\"P1\" 1.5 -2 3 0 0 1 0.0 -0.1 0.1 SP\n'P2' 4 5 6.25 0 0 1 0.0 -0.1 0.1 SP\n",
        "Name,X,Y,Z\nP1,1.5,-2,3\nP2,4,5,6.25\n",
        "Point Name;X [mm];Y [mm];Z [mm]\nP1;1,5;-2;3\nP2;4;5;6,25\n",
        "id,group,nominal x,measured x,measured y,measured z,dev x\nP1,g,9,1.5,-2,3,0\nP2,g,9,4,5,6.25,0\n",
        "X,Y,Z,Measured X,Measured Y,Measured Z,Label\n9,9,9,1.5,-2,3,P1\n8,8,8,4,5,6.25,P2\n",
        "P1 1.5e0 -2e0 3\nP2 4 5 .625e1\n",
        "\ufeffP1 1.5 -2 3\nP2 4 5 6.25\n",
    ],
)
def test_the_usual_forms_say_the_same(text):
    assert told(text) == TWO


def test_points_may_be_called_by_numbers():
    assert told("1 10.5 20.0 30.0\n2 11.5 21.0 31.0\n") == [
        ("1", (10.5, 20.0, 30.0)),
        ("2", (11.5, 21.0, 31.0)),
    ]
    assert [name for name, _ in told("A G 7 1.5 2 3\nA G 8 1.5 2 3\n")] == ["7", "8"]


def test_whole_coordinates_behind_a_name_are_coordinates():
    assert told("P1 1 2 3 0 0 1\nP2 4 5 6 0 0 1\n") == [("P1", (1.0, 2.0, 3.0)), ("P2", (4.0, 5.0, 6.0))]


@pytest.mark.parametrize(
    "text",
    [
        "// Units: Inches\nP1 1 0 0\n",
        "// Length unit = in\nP1 1 0 0\n",
        "Name,X (in),Y (in),Z (in)\nP1,1,0,0\n",
        "Name,x_inch,y_inch,z_inch\nP1,1,0,0\n",
    ],
)
def test_a_list_that_states_its_unit_needs_none(text):
    assert told(text, None) == [("P1", (25.4, 0.0, 0.0))]


def test_a_unit_is_never_guessed_and_never_overruled():
    with pytest.raises(WrongUnitError, match="does not state its unit; specify one: mm, m, cm, in"):
        read("P1 1 2 3\n", None)
    with pytest.raises(WrongUnitError, match="states the unit mm, but in was specified"):
        read("// Units: Millimeters\nP1 1 2 3\n", "in")
    assert told("P1 1 2 3\n", "m") == [("P1", (1000.0, 2000.0, 3000.0))]


def test_uncertainties_count_where_a_header_names_them():
    (point,) = read("Name,X,Y,Z,Ux,Uy,Uz\nP1,1,2,3,0.01,0.02,0.03\n")
    (silent,) = read("P1 1 2 3 0.01 0.02 0.03\n")

    assert point.uncertainty_mm == (0.01, 0.02, 0.03)
    assert silent.uncertainty_mm is None


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("", UnreadableFileError, "no point"),
        ("// only this\n", UnreadableFileError, "no point"),
        ("Name,X,Y,Z\n", UnreadableFileError, "no point"),
        ("1.5 2.5 3.5\n", MissingEntryError, "no names"),
        ("P1 1 2 3\nP2 1 two 3\n", BadValueError, "line 2: 'two' is not a coordinate"),
        ("P1 1 2 3\nP2 1 2\n", UnreadableFileError, "line 2: 3 fields found where 4"),
        ("X,Y,Z,Name\n1,2,3,P1\n4,5,6\n", UnreadableFileError, "line 3: 3 fields found where 4"),
        ("P1 1 2 3\nP1 4 5 6\n", BadValueError, "line 2: point 'P1' is in line 1 as well"),
        ("P1 1 2 3\nP2 1 2 nan\n", BadValueError, "line 2: 'nan' is not a coordinate"),
        ("P1 1 2 3\nP2 1 2 1e999\n", BadValueError, "line 2: '1e999' is not a coordinate"),
        (
            f"P1,1,2,{'3' * 140_000}\n",
            UnreadableFileError,
            "line 1: the line has more than 65,536 characters",
        ),
        (f"P1 1 2 {'3' * 5000}\n", BadValueError, "...' is not a coordinate"),
        ("\0\0P1 1 2 3\n", UnreadableFileError, "not text"),
    ],
)
def test_what_is_no_list_is_refused_with_its_line(text, error, said):
    with pytest.raises(error) as refused:
        read(text)

    assert said in str(refused.value)
    assert str(refused.value).startswith("points.txt")
