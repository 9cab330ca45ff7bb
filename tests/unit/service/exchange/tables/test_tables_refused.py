"""Every mistake in a table is refused with file, line and column in one sentence."""

import pytest

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.errors import (
    BadValueError,
    MissingEntryError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.exchange.tables.files import visits_from

HEADER = "config,q1_deg,q2_deg,q3_deg,nest,x_mm,y_mm,z_mm,u_mm"
ROWS = ("1,0,10,20,1,100,200,300,0.02", "2,5,15,25,1,110,210,310,0.02", "3,6,16,26,1,120,220,320,0.02")


def points(header=HEADER, rows=ROWS):
    return "\n".join([header, *rows, ""])


def with_columns(names, *cells):
    return points(f"{HEADER},{names}", [f"{row},{cell}" for row, cell in zip(ROWS, cells, strict=True)])


def second_row(row):
    return points(rows=(ROWS[0], row, ROWS[2]))


def read(calibration, **changes):
    data = calibration if isinstance(calibration, bytes) else calibration.encode()
    files = {**{name: text.encode() for name, text in campaign_files(make_campaign(**changes)).items()}}
    return campaign_from({**files, "calibration.csv": data}.__getitem__)


CELLS = {
    "not a number": ("y_mm", "NaN", "'NaN' is not a finite number"),
    "an infinite number": ("y_mm", "1e999", "is not a finite number"),
    "text where a number belongs": ("q2_deg", "fifteen", "'fifteen' is not a number"),
    "digits of another script": ("q2_deg", "\u0661", "is not a number"),
    "an underscore in a number": ("q2_deg", "1_5", "'1_5' is not a number"),
    "a decimal comma": ("q2_deg", '"15,5"', "the decimal point is ."),
    "a number beyond all quantities": (
        "y_mm",
        "1e200",
        "is not a plausible length: the limit is 1,000,000 mm; correct it, or remove",
    ),
    "a cell of two lines": ("q2_deg", '"15\n5"', "is not a number"),
    "an empty cell": ("y_mm", "", "the cell is empty"),
    "a fractional configuration": ("config", "2.5", "must be a whole number"),
    "a negative configuration": ("config", "-2", "must not be below 0"),
    "a configuration beyond whole numbers": ("config", "1e20", "must be a whole number"),
    "a nest that is none": ("nest", "2", "must be one of the tool nests: 1"),
    "no uncertainty": ("u_mm", "0", "must be greater than 0"),
}


@pytest.mark.parametrize("case", CELLS)
def test_a_mistake_in_a_cell_is_refused_where_it_is(case):
    column, cell, sentence = CELLS[case]
    cells = dict(zip(HEADER.split(","), ROWS[1].split(","), strict=True)) | {column: cell}

    require_refused(second_row(",".join(cells.values())), BadValueError, (3, column), sentence)


MORE_COLUMNS = {
    "a direction of 2": ("dir1", (1, 2, 1), "must lie between -1 and 1"),
    "a quaternion of length 1.1": (
        "qw,qx,qy,qz",
        ("1,0,0,0", "1.1,0,0,0", "1,0,0,0"),
        "not a unit quaternion",
    ),
    "a covariance that is none": (
        "cxx,cxy,cxz,cyy,cyz,czz",
        ("1,0,0,1,0,1", "1,2,0,1,0,1", "1,0,0,1,0,1"),
        "not a positive definite matrix",
    ),
}


@pytest.mark.parametrize("case", MORE_COLUMNS)
def test_a_mistake_in_a_column_that_may_be_left_out_is_refused_where_it_is(case):
    names, cells, sentence = MORE_COLUMNS[case]

    require_refused(with_columns(names, *cells), BadValueError, (3, names.split(",")[0]), sentence)


MISSING = {
    "a required column": (points().replace("u_mm", "sigma"), "column u_mm is missing"),
    "a joint column": (points().replace("q3_deg", "axis3"), "column q3_deg is missing"),
    "half a quaternion": (with_columns("qw,qx", *["1,0"] * 3), "column qy is missing"),
    "half a covariance": (with_columns("cxx,cxy", *["1,0"] * 3), "column cxz is missing"),
    "along the beam": (with_columns("u_across_mm", 1, 1, 1), "column u_along_mm is missing"),
    "torques of two joints of three": (with_columns("tau1_Nm,tau2_Nm", *["1,2"] * 3), "tau3_Nm is missing"),
}


@pytest.mark.parametrize("case", MISSING)
def test_a_column_that_is_missing_is_named(case):
    text, sentence = MISSING[case]

    require_refused(text, MissingEntryError, (1, None), sentence)


HEADINGS = {
    "a beam from nowhere": (
        with_columns("u_along_mm,u_across_mm", *["1,1"] * 3),
        MissingEntryError,
        (1, "u_along_mm"),
        "need tracker_position_world_mm in campaign.json",
    ),
    "a column twice": (
        points().replace("y_mm", "x_mm"),
        BadValueError,
        (1, "x_mm"),
        "the column appears twice",
    ),
    "a header below blank lines": (
        "\n,,\n" + points().replace("u_mm", "sigma"),
        MissingEntryError,
        (3, None),
        "column u_mm is missing",
    ),
}


@pytest.mark.parametrize("case", HEADINGS)
def test_a_mistake_in_the_header_is_refused_where_it_is(case):
    require_refused(*HEADINGS[case])


OTHER_UNITS = {
    "positions in metres": (
        points().replace("x_mm", "x_m"),
        "calibration.csv, line 1: column x_m has the unit m; x_mm in mm is required.",
    ),
    "joints in radians": (points().replace("q2_deg", "q2_rad"), "q2_rad has the unit rad; q2_deg in deg"),
    "no unit": (points().replace("y_mm", "y"), "column y has no unit; y_mm in mm is required"),
    "an optional column": (with_columns("temperature_K", *[293] * 3), "temperature_C in C is required"),
    "torques": (with_columns("tau1_Nmm,tau2_Nmm,tau3_Nmm", *["1,2,3"] * 3), "tau1_Nmm"),
}


@pytest.mark.parametrize("case", OTHER_UNITS)
def test_a_column_in_another_unit_is_refused_with_the_one_that_is_required(case):
    text, sentence = OTHER_UNITS[case]

    require_refused(text, WrongUnitError, (1, None), sentence)


UNREADABLE = {
    "a cell too few": (second_row("2,5,15,25,1,110,210,310"), 3, "8 cells found where"),
    "a cell too many": (second_row("2,5,15,25,1,110,210,310,0.02,7"), 3, "10 cells found where"),
    "an empty file": ("", None, "the file is empty"),
    "a file of a byte order mark": (b"\xef\xbb\xbf", None, "the file is empty"),
    "a header alone": (HEADER + "\n", None, "a header and no rows"),
    "semicolons": (points().replace(",", ";"), 1, "separated by semicolons"),
    "tabs": (points().replace(",", "\t"), 1, "separated by tabs"),
    "another encoding": (points().encode().replace(b"110", b"11\xe4"), 3, "not UTF-8"),
    "an unclosed quote": (second_row('"2,5'), 3, "the line is not CSV"),
}


@pytest.mark.parametrize("case", UNREADABLE)
def test_what_is_no_table_is_refused_where_it_begins(case):
    text, line, sentence = UNREADABLE[case]

    require_refused(text, UnreadableFileError, (line, None), sentence)


def test_a_table_of_visits_with_a_heading_twice_is_refused():
    with pytest.raises(BadValueError, match="the column appears twice") as refusal:
        visits_from("visits.csv", b"campaign,robot,instrument,day,day\na,1,2,2026-03-03,\n")

    assert (refusal.value.line, refusal.value.column) == (1, "day")


def require_refused(text, kind, place, sentence):
    with pytest.raises(kind) as refusal:
        read(text)

    error = refusal.value
    assert (error.file, error.line, error.column) == ("calibration.csv", *place)
    assert sentence in str(error)
    assert_one_sentence(error)


def assert_one_sentence(error):
    assert str(error).endswith(".")
    assert "\n" not in str(error)


TWO_BAD_CELLS = (ROWS[0], "2,5,15,25,1,110,bad,worse,0.02", "x,6,16,26,1,120,220,320,0.02")
BELOW_A_BLANK_LINE = (ROWS[0], "", ROWS[1], "3,6,16,26,1,120,bad,320,0.02")


@pytest.mark.parametrize(("rows", "line"), [(TWO_BAD_CELLS, 3), (BELOW_A_BLANK_LINE, 5)])
def test_the_bad_cell_read_first_is_named_by_its_line_of_the_file(rows, line):
    require_refused(points(rows=rows), BadValueError, (line, "y_mm"), "'bad' is not a number")


def test_the_point_in_the_tracker_itself_has_no_beam():
    text = with_columns("u_along_mm,u_across_mm", "1,1", "1,1", "1,1")

    with pytest.raises(BadValueError) as refusal:
        read(text, tracker_position_mm=(110.0, 210.0, 310.0))

    assert (refusal.value.line, refusal.value.column) == (3, "x_mm")


BALLBAR_REFUSED = {
    "a leg of no length": ("legs", "300.12500", "0", 3, "length_mm", "must be greater than 0"),
    "a base point 5": ("legs", "1,1,300.12500", "5,1,300.12500", 3, "base_point", "between 1 and 4"),
    "a tool point that is no nest": (
        "legs",
        "1,1,300.12500",
        "1,4,300.12500",
        3,
        "tool_point",
        "the tool nests: 1",
    ),
    "placement 0 of a leg": ("legs", "\n1,2,", "\n0,2,", 3, "placement", "must not be below 1"),
    "the tool in placement 1": ("fixture", "1,base", "1,tool", 3, "kind", "placement 0 is the tool"),
    "a kind of its own": ("fixture", "1,base", "1,table", 3, "kind", "must be tool or base"),
    "a side of one point": (
        "fixture",
        "base,1,3",
        "base,1,1",
        3,
        "point_b",
        "must join two different points",
    ),
    "a cup that is text": ("cups", "1,2,", "1,two,", 2, "base_point", "'two' is not a number"),
    "a set-up without an angle": ("setup", "12.250000000,12", ",12", 2, "q1_deg", "the cell is empty"),
    "an uncertified fixed nest": (
        "reference",
        "60.5000,1",
        "60.5000,2",
        3,
        "fixed_nest",
        "the fixed nests: 1",
    ),
}


@pytest.mark.parametrize("case", BALLBAR_REFUSED)
def test_a_mistake_in_the_other_tables_is_refused_where_it_is(case):
    role, old, new, line, column, sentence = BALLBAR_REFUSED[case]
    files = campaign_files(make_ballbar_campaign())
    edited = files[f"{role}.csv"].replace(old, new)
    assert edited != files[f"{role}.csv"]

    with pytest.raises(BadValueError) as refusal:
        campaign_from(lambda name: {**files, f"{role}.csv": edited}[name].encode())

    error = refusal.value
    assert (error.file, error.line, error.column) == (f"{role}.csv", line, column)
    assert sentence in str(error)
    assert_one_sentence(error)


@pytest.mark.parametrize("role", ["fixture", "setup", "cups", "reference"])
def test_every_column_of_the_small_tables_is_required(role):
    files = campaign_files(make_ballbar_campaign())
    header = files[f"{role}.csv"].splitlines()[0]

    for column in header.split(","):
        edited = files[f"{role}.csv"].replace(header, header.replace(column, "else"))
        with pytest.raises((MissingEntryError, WrongUnitError), match=column):
            campaign_from(lambda name, text=edited: {**files, f"{role}.csv": text}[name].encode())
