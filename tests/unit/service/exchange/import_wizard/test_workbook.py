"""Workbooks: each sheet is a table, and what cannot be read is said in its place."""

from datetime import date

import numpy as np
import pytest

from tests.helpers.exchange.workbooks import workbook
from tests.unit.service.exchange.import_wizard.tables import plain, readings
from truepose.exchange.errors import UnreadableFileError, UnsafeArchiveError
from truepose.exchange.import_wizard.dialogue import Choices, FileChoice
from truepose.exchange.import_wizard.reading import read_imported_files
from truepose.exchange.import_wizard.workbook import is_workbook, read_workbook

DAY = Choices(measured_on=date(2026, 3, 3))
NAMES = ["pose", *(f"J{k} [deg]" for k in range(1, 7)), "nest", "x [mm]", "y [mm]", "z [mm]", "u [mm]"]


def measured(n=30):
    joints, nest, places = readings(n)
    numbers = np.column_stack([np.arange(n), joints, nest, places, np.full(n, 0.02)])
    return [NAMES, *(list(map(float, row)) for row in numbers)]


def text_of(cells, **more):
    (text,) = read_workbook(workbook({"Sheet1": [cells]}, **more), "mine.xlsx").values()
    return text.decode().split("\t")


@pytest.mark.parametrize("target", ["worksheets/sheet{}.xml", "/xl/worksheets/sheet{}.xml"])
def test_a_sheet_is_a_table_as_its_csv_is(target):
    of_book = read_imported_files({"mine.xlsx": workbook({"Tabelle1": measured()}, target)}, DAY)
    of_table = read_imported_files({"mine.csv": plain()}, DAY)

    assert of_book.understood.ready
    assert [one.name for one in of_book.understood.files] == ["mine (Tabelle1).txt"]
    assert of_book.campaign.calibration.position_mm == pytest.approx(
        of_table.campaign.calibration.position_mm, abs=1e-4
    )


def test_every_visible_sheet_that_holds_something_is_a_table():
    sheets = {"raw": measured(), "Blätter/2": measured(), "empty": [], "notes": [["by", "Ada"]]}

    found = read_workbook(workbook(sheets, state="hidden"), "left arm.xlsx")

    assert list(found) == ["left arm (Blätter_2).txt", "left arm (notes).txt"]


def test_rows_keep_their_numbers_and_cells_their_columns():
    rows = [["Measured by", "Ada"], [], [None, "x", None, "z"], [None, 1.5, None, -2e-07]]

    (text,) = read_workbook(workbook({"S": rows}), "mine.xlsx").values()

    assert text.decode().split("\n") == ["Measured by\tAda", "", "\tx\t\tz", "\t1.5\t\t-2e-07"]


def test_a_fault_is_shown_at_the_row_of_the_sheet_and_corrected_there():
    rows = measured()
    rows[7][8] = "1o2.5"
    files = {"mine.xlsx": workbook({"S": rows})}

    wrong = read_imported_files(files, DAY).understood.fault
    left_out = Choices(files={"mine (S).txt": FileChoice(edits={8: None})}, measured_on=DAY.measured_on)
    right = read_imported_files(files, left_out)

    assert (wrong.file, wrong.line, wrong.column) == ("mine (S).txt", 8, 8)
    assert right.understood.readings == 29


@pytest.mark.parametrize(
    ("cell", "shown"),
    [
        ("<c><v>12.25</v></c>", "12.25"),
        ("<c><f>A1*2</f><v>24.5</v></c>", "24.5"),  # what the formula came to
        ('<c t="str"><f>UPPER(A1)</f><v>UP</v></c>', "UP"),
        ('<c t="inlineStr"><is><t>in</t><t> line</t></is></c>', "in line"),
        ('<c t="b"><v>1</v></c>', "1"),
        ('<c t="e"><v>#N/A</v></c>', "#N/A"),
        ('<c s="1"><v>46146</v></c>', "2026-05-04"),
        ('<c s="2"><v>46146.384108796</v></c>', "2026-05-04T09:13:07"),
        ('<c s="2"><v>0.5</v></c>', "12:00:00"),
        ('<c s="3"><v>46146</v></c>', "46146"),  # its form says "day" in quotes only
        ('<c s="1"><v>-3</v></c>', "-3.0"),
        ("two\nlines\there", "two lines here"),
        ('"quoted"', '"""quoted"""'),
    ],
)
def test_a_cell_is_what_the_spreadsheet_shows(cell, shown):
    assert text_of([cell, "end"]) == [shown, "end"]


def test_days_of_old_macintoshes_begin_in_1904():
    assert text_of(['<c s="1"><v>44684</v></c>'], head='<workbookPr date1904="1"/>') == ["2026-05-04"]


def test_a_text_in_several_looks_is_one_and_how_it_is_read_is_none_of_it():
    rich = "<sst><si><r><t>x</t></r><r><t> [mm]</t></r><rPh><t>ekkusu</t></rPh></si></sst>"

    assert text_of(["x"], also={"xl/sharedStrings.xml": rich}) == ["x [mm]"]


def sheet(rows):
    """Return a workbook of one sheet with these rows."""
    return workbook({"S": []}, also={"xl/worksheets/sheet1.xml": f"<worksheet>{rows}</worksheet>"})


FAR = range(1, 8002)  # rows whose only cell is the last that is read
BANANA = '<?xml version="1.0" encoding="banana"?><styleSheet/>'
BOMB = '<!DOCTYPE sst [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]><sst><si><t>&b;</t></si></sst>'


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (workbook({"S": [["<c><f>A1*2</f></c>"]]}), "a formula has no stored result"),
        (
            workbook({"S": [['<c t="s"><v>7</v></c>']]}, also={"xl/sharedStrings.xml": "<sst/>"}),
            "cannot be read: the workbook has no text 7",
        ),
        (workbook({"S": [["last", '<c t="s"><v>-1</v></c>']]}), "cannot be read: '-1' is not the number"),
        (workbook({"S": [['<c s="-1"><v>46146</v></c>']]}), "cannot be read: '-1' is not the number"),
        (workbook({"S": [['<c t="s"><v>' + "7" * 5000 + "</v></c>"]]}), "cannot be read: '777"),
        (sheet('<row r="-5"><c><v>1</v></c></row>'), "cannot be read: '-5' is not the number"),
        (sheet("".join(f'<row r="{k}"><c r="SF{k}"><v>1</v></c></row>' for k in FAR)), "too many cells"),
        (sheet('<row r="0"><c><v>1</v></c></row>'), "too many cells"),
        (workbook({"S": [["x" * 2**18], *[['<c t="s"><v>0</v></c>'] * 256]]}), "too much text"),
        (workbook({"S": [["x"]]}, also={"xl/styles.xml": BANANA}), "its encoding is not known"),
        (workbook({"S": [["x"]], "T": [["x"]]}, target="worksheets/sheet1.xml"), "refer to the same part"),
        (workbook({"S": [["x"]]}, also={"xl/sharedStrings.xml": BOMB}), "declares a document type"),
        (workbook({"S": [["x"]]}, also={"xl/worksheets/sheet1.xml": "<worksheet><row>"}), "is damaged"),
        (workbook({"S": [["x"]]}, target="worksheets/other{}.xml"), "has no part xl/worksheets/other1.xml"),
        (workbook({"S": [["x"]]})[:-30], "not a complete zip file"),
        (sheet('<row r="300000"><c><v>1</v></c></row>'), "too many cells"),
    ],
    ids=lambda told: told if isinstance(told, str) else "workbook",  # the bytes of a zip hold the time
)
def test_what_cannot_be_read_is_said_and_the_file_beside_it_is_read(data, says):
    with pytest.raises(UnreadableFileError, match=says):
        read_workbook(data, "mine.xlsx")

    found = read_imported_files({"mine.xlsx": data, "other.csv": plain()}, DAY)

    assert says in {one.name: one for one in found.understood.files}["mine.xlsx"].reason
    assert found.understood.readings == 30


def test_a_workbook_that_grows_without_end_is_refused():
    with pytest.raises(UnsafeArchiveError):
        read_workbook(workbook({"S": [["x"]]}, also={"xl/media/picture": " " * 2**25}), "mine.xlsx")


@pytest.mark.parametrize(("name", "data"), [("mine.csv", b"PK"), ("mine.xlsx", b"x;y"), ("mine.zip", b"PK")])
def test_other_files_are_no_workbooks(name, data):
    assert not is_workbook(name, data)
