"""Readings to set aside as people write them, on the command line and in a table."""

import pytest

from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import BadValueError, MissingEntryError
from truepose.exchange.tables.set_aside import read_set_aside_table, reading_and_reason


@pytest.fixture
def table(tmp_path):
    def written(text):
        file = tmp_path / "aside.csv"
        file.write_text(text)
        return file

    return written


@pytest.mark.parametrize(
    ("text", "understood"),
    [
        ("17=bumped the tripod", ((17,), "bumped the tripod")),
        ("17/2=x = 0 was wrong", ((17, 2), "x = 0 was wrong")),
        (" 17 / 3 / 2 =  a cable\n lay there ", ((17, 3, 2), "a cable lay there")),
    ],
)
def test_a_reading_is_named_by_its_numbers_and_has_a_reason(text, understood):
    assert reading_and_reason(text) == understood


@pytest.mark.parametrize("text", ["17", "17=", "17= ", f"17={'x' * 501}"])
def test_a_reason_is_required(text):
    with pytest.raises(ConfigurationError, match=r"^--set-aside 17: a reason .* is required, as in"):
        reading_and_reason(text)


@pytest.mark.parametrize(
    "text",
    ["the tripod was bumped", "=bumped", "17/=x", "-1=x", "1.5=x", "9999999999=x"],
)
def test_what_is_no_number_is_refused_with_an_example(text):
    with pytest.raises(ConfigurationError, match=r'name the reading by the numbers .* as in "17/2=a cable'):
        reading_and_reason(text)


def test_a_table_names_many_and_may_have_other_columns(table):
    file = table(
        "config,nest,base_point,after_mm,reason\n"
        "17,2,,0.31,bumped the tripod\n"
        "18,1,3,0.02,'=a cable\n"
        "19,,,,a cable\n"
    )

    assert read_set_aside_table(file) == [
        ((17, 2), "bumped the tripod"),
        ((18, 3, 1), "=a cable"),
        ((19,), "a cable"),
    ]


def test_the_columns_of_tables_of_lengths_are_known(table):
    file = table("placement,config,base_point,tool_point,reason\n1,17,3,2,a cable\n")

    assert read_set_aside_table(file) == [((17, 3, 2), "a cable")]


@pytest.mark.parametrize(
    ("text", "error", "why"),
    [
        ("config,nest\n17,2\n", MissingEntryError, r"aside\.csv, line 1: column reason is missing"),
        ("nest,reason\n2,a cable\n", MissingEntryError, "column config is missing"),
        ("config,nest,reason\n17,2,\n", BadValueError, r"line 2, column reason: a reason"),
        ("config,nest,reason\n17,b,a cable\n", BadValueError, r"line 2, column nest: 'b' is not the number"),
        ("config,nest,reason\n,2,a cable\n", BadValueError, r"line 2, column config: '' is not"),
    ],
)
def test_what_a_table_lacks_is_said_with_file_line_and_column(table, text, error, why):
    with pytest.raises(error, match=why):
        read_set_aside_table(table(text))
