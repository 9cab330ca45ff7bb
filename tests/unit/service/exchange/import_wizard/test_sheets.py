"""Where the table of a file begins, what separates its cells, and which mark its decimals have."""

import pytest

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.import_wizard.sheet import LONGEST_LINE, read_sheet

ROWS = "a,b,c,d\n1,2.5,3,4\n5,6.5,7,8\n"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
def test_a_table_is_read_in_the_encodings_of_spreadsheets(encoding):
    sheet = read_sheet("mine.csv", "Größe,b,c,d\n1,2.5,3,4\n".encode(encoding))

    assert sheet.header[0] == "Größe"
    assert sheet.rows[0].cells == ("1", "2.5", "3", "4")


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_of_every_system_count_alike(end):
    sheet = read_sheet("mine.csv", ROWS.replace("\n", end).encode())

    assert [row.line for row in sheet.rows] == [2, 3]


@pytest.mark.parametrize(
    ("text", "separator"),
    [
        ("a;b;c\n1,5;2,5;3,5\n", ";"),
        ("a\tb\tc\n1,5\t2,5\t3,5\n", "\t"),
        ("a b c\n1,5 2,5 3,5\n", None),
        ("a|b|c\n1,5|2,5|3,5\n", "|"),
    ],
)
def test_decimal_commas_are_told_from_separators(text, separator):
    sheet = read_sheet("mine.txt", text.encode())

    assert (sheet.separator, sheet.decimal) == (separator, ",")
    assert sheet.rows[0].cells == ("1.5", "2.5", "3.5")


def test_thousands_are_no_decimals():
    sheet = read_sheet("mine.csv", b"a;b;c\n1.234,56;-12.345.678,9;3,5\n1,5;2,5;0,25\n")

    assert sheet.rows[0].cells == ("1234.56", "-12345678.9", "3.5")


def test_titles_above_the_header_and_units_below_it_belong_to_it():
    text = "Report of a tracker;;\nStation 1;;\nq1;x;y\n[deg];[mm];[mm]\n1,5;2,5;3,5\n"

    sheet = read_sheet("mine.csv", text.encode())

    assert sheet.header == ("q1 [deg]", "x [mm]", "y [mm]")
    assert sheet.rows[0].line == 5


def test_a_table_without_names_has_none():
    sheet = read_sheet("mine.csv", b"1,2.5,3\n4,5.5,6\n")

    assert sheet.header == ("", "", "")
    assert sheet.header_line is None


def test_comments_are_no_rows_and_a_commented_header_is_one():
    sheet = read_sheet("mine.txt", b"# a b c\n1 2.5 3\n// 4 5.5 6\n7 8.5 9\n")

    assert sheet.header == ("a", "b", "c")
    assert [row.line for row in sheet.rows] == [2, 4]


def test_a_corrected_line_counts_and_one_left_out_does_not():
    sheet = read_sheet("mine.csv", ROWS.encode(), {2: "1,9.5,3,4", 3: None})

    assert [(row.line, row.cells[1]) for row in sheet.rows] == [(2, "9.5")]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"PK\x03\x04rest", "save the sheet as CSV"),
        (b"\xd0\xcf\x11\xe0rest", "save the sheet as CSV"),
        (b"%PDF-1.7", "export the readings"),
        (b"a,b\0,c\n1,2,3\n", "not text"),
        (b"a letter\nto somebody\n", "no table of numbers"),
        (b"", "no table of numbers"),
        (b"a,b,c\n" + b"1" * (LONGEST_LINE + 1), "characters"),
        (b",".join([b"1"] * 501), "columns"),
        (b"\n" * 1_000_001, "more than 1,000,000 lines"),
    ],
)
def test_what_is_no_table_is_refused_in_a_sentence(data, words):
    with pytest.raises(UnreadableFileError, match=words):
        read_sheet("mine.csv", data)
