"""Values that nobody could have read or meant are refused, with the place where they stand."""

import json

import pytest

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.exchange.document import Node, json_document, toml_document
from truepose.exchange.errors import BadValueError, UnreadableFileError
from truepose.exchange.quantities import limits_of
from truepose.exchange.tables.rows import MOST_ROWS
from truepose.exchange.tables.table_reader import Column, read_table


def files_of(campaign=None):
    return {name: text.encode() for name, text in campaign_files(campaign or make_campaign()).items()}


def with_cells(files, file, changes):
    """The files with cells of a table replaced: (row, column) -> text; row 0 stands on line 2."""
    header, *rows = [line.split(",") for line in files[file].decode().splitlines()]
    for (row, column), cell in changes.items():
        rows[row][header.index(column)] = cell
    text = "\n".join(",".join(row) for row in [header, *rows]) + "\n"
    return {**files, file: text.encode()}


@pytest.mark.parametrize(
    ("make", "file", "column"),
    [
        *[
            (make_campaign, "calibration.csv", column)
            for column in ("x_mm", "y_mm", "z_mm", "q2_deg", "u_mm")
        ],
        (make_ballbar_campaign, "legs.csv", "length_mm"),
        (make_ballbar_campaign, "fixture.csv", "length_mm"),
        (make_ballbar_campaign, "setup.csv", "q1_deg"),
    ],
)
@pytest.mark.parametrize("cell", ["1e9", "1e12", "1e29", "1e300", "inf", "nan", "-1e12", "-inf"])
def test_a_number_that_no_instrument_said_is_refused_where_it_stands(make, file, column, cell):
    files = with_cells(files_of(make()), file, {(0, column): cell})

    with pytest.raises(BadValueError) as refusal:
        campaign_from(files.__getitem__)

    assert (refusal.value.file, refusal.value.line, refusal.value.column) == (file, 2, column)


@pytest.mark.parametrize(
    ("column", "cell", "sentence"),
    [
        ("u_mm", "1001", "'1001' mm is not a plausible standard uncertainty"),
        ("u_mm", "1e-200", "smaller than the standard uncertainty of any instrument"),
        ("config", "1", r"line 4, column config: configuration 1 is on line 2 with other joints \(q1"),
    ],
    ids=["a worthless reading", "a reading too good", "two places of the arm under one number"],
)
def test_a_cell_that_nobody_can_have_meant_is_refused(column, cell, sentence):
    files = with_cells(files_of(), "calibration.csv", {(2, column): cell})

    with pytest.raises(BadValueError, match=sentence):
        campaign_from(files.__getitem__)


@pytest.mark.parametrize(
    ("name", "possible", "impossible"),
    [
        ("x_mm", 999_999.0, 1_000_001.0),
        ("q3_deg", 40_000.0, 400_000.0),
        ("tau4_Nm", 30_000.0, 2e6),
        ("temperature_C", -40.0, 3000.0),
        ("time_s", 1_764_000_000.0, 1_764_000_000_000.0),  # since 1970; the same in milliseconds
        ("tool_nest_u_mm", 0.002, 2000.0),
        ("u_rot_deg", 0.01, 181.0),
        ("kg", 400.0, 2e6),
    ],
)
def test_a_limit_goes_with_the_unit_of_the_name(name, possible, impossible):
    limits = limits_of(name)

    assert limits.accepts(possible)
    assert limits.accepts(-possible)
    assert not limits.accepts(impossible)


def test_numbers_of_a_description_keep_to_the_same_limits():
    files = files_of()
    document = json.loads(files["campaign.json"])
    document["tool_nests_mm"][0] = [0.0, 1e12, 0.0]
    files["campaign.json"] = json.dumps(document).encode()

    with pytest.raises(BadValueError, match=r"tool_nests_mm\[0\]\[1\]: 1e\+12 mm is not a plausible length"):
        campaign_from(files.__getitem__)


def test_a_covariance_that_makes_a_reading_worthless_is_refused():
    header, *rows = files_of()["calibration.csv"].decode().splitlines()
    rows = [f"{row},1e18,0,0,1e18,0,1e18" for row in rows]
    text = "\n".join([f"{header},cxx,cxy,cxz,cyy,cyz,czz", *rows])

    with pytest.raises(BadValueError, match="are too large: they are in mm2"):
        campaign_from({**files_of(), "calibration.csv": text.encode()}.__getitem__)


def test_legs_of_two_placements_may_share_numbers():
    files = with_cells(
        files_of(make_ballbar_campaign()), "legs.csv", {(1, "placement"): "2", (1, "config"): "1"}
    )

    assert len(campaign_from(files.__getitem__).legs) == len(make_ballbar_campaign().legs)


def test_a_kind_that_there_is_not_is_refused_with_the_known_ones():
    files = files_of()
    files["campaign.json"] = files["campaign.json"].replace(b'"kind": "tracker"', b'"kind": "banana"')

    with pytest.raises(BadValueError, match="'banana' is not a kind of campaign; it must be one of tracker"):
        campaign_from(files.__getitem__)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('{"a": 1, "b": 2, "a": 3}', "key a appears twice"),
        ('{"a": NaN}', "NaN is not a finite number"),
        ('{"a": -Infinity}', "-Infinity is not a finite number"),
        ("[" * 100_000, "nested too deeply"),
        ("[" * 900 + "]" * 900, "nested too deeply"),
        ('{"a": ' + "9" * 5000 + "}", "not a usable JSON document"),
        ('{"a": "\\ud800"}', "surrogates not allowed"),
    ],
)
def test_json_that_means_nothing_is_refused_in_one_sentence(text, sentence):
    with pytest.raises(UnreadableFileError, match=sentence):
        json_document("a.json", text.encode())


def test_a_character_of_two_halves_is_whole():
    assert json_document("a.json", b'{"a": "\\ud83d\\ude00"}').key("a").text() == "\U0001f600"


@pytest.mark.parametrize(
    "text",
    ["a = " + "9" * 5000, "a = " + "[" * 100_000, "a" + ".b" * 3000 + " = 1", "a = 1\na = 2\n", "a = nan"],
)
def test_toml_that_means_nothing_is_refused_in_one_sentence(text):
    with pytest.raises((UnreadableFileError, BadValueError)):
        toml_document("a.toml", text.encode()).key("a").number()


@pytest.mark.parametrize("read", [Node.text, Node.truth, Node.number])
def test_a_number_of_thousands_of_digits_is_named_and_not_printed(read):
    with pytest.raises(
        BadValueError, match=r"a number of thousands of digits (is|must)|the number is not finite"
    ):
        read(toml_document("a.toml", b"a = 0x" + b"f" * 5000).key("a"))


def test_a_text_of_a_whole_book_is_refused():
    with pytest.raises(BadValueError, match="more than 4000 characters"):
        json_document("a.json", json.dumps({"a": "x" * 5000}).encode()).key("a").text()


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (b"q\n" + b"1\n" * (MOST_ROWS + 1), "more than 200,000 rows"),
        (b",".join(b"c%d" % k for k in range(501)) + b"\n", "501 columns exceed the limit of 500"),
        (b"q\n" + b"1" * 10**6, "line 2: the line has more than 65,536 characters"),
    ],
    ids=["rows", "columns", "a line without end"],
)
def test_a_table_of_too_much_is_refused(data, sentence):
    with pytest.raises(UnreadableFileError, match=sentence):
        read_table("t.csv", data, [Column("q")])


def test_a_table_of_as_many_rows_as_are_read_is_read():
    table = read_table("t.csv", b"q\n" + b"1\n" * MOST_ROWS, [Column("q")])

    assert (len(table.lines), int(table.lines[-1])) == (MOST_ROWS, MOST_ROWS + 1)


@pytest.mark.parametrize(
    ("bad", "kind"), [(b"x", BadValueError), (b"\xff", UnreadableFileError)], ids=["a cell", "no text"]
)
def test_what_is_bad_far_down_is_found_on_its_line(bad, kind):
    rows = [b"1"] * 9000
    rows[8500] = bad

    with pytest.raises(kind) as refusal:
        read_table("t.csv", b"\n".join([b"q", *rows]), [Column("q")])

    assert refusal.value.line == 8502
