"""What is kept in mm, degrees and °C, in the units of a reader: of one number, and of every text there is."""

import math
import re

import pytest

from truepose.reports.wording.rounding import exact, fixed, interval, millimetres, rounded, with_uncertainty
from truepose.words.catalogue import ENGLISH, LANGUAGES, catalogue
from truepose.words.units import KEPT, Conversion, Printed, Units

INCH = Units.of(["inch", "rad", "f"])
BLANKS = re.compile(r"\{(\w+):[^}|]*\|([^|}]*)")


@pytest.mark.parametrize(
    ("value", "unit", "shown", "symbol"),
    [
        (25.4, "mm", 1.0, "in"),
        (25.4, "um", 0.001, "in"),
        (180.0, "deg", math.pi, "rad"),
        (20.0, "°C", 68.0, "°F"),
        (5.0, "K", 9.0, "°F"),
        (1.0, "deg/K", math.pi / 324.0, "rad/°F"),
        (254.0, "mm/h", 10.0, "in/h"),
    ],
)
def test_a_kept_value_becomes_the_readers(value, unit, shown, symbol):
    conversion = INCH.conversion(unit)

    assert conversion.of(value) == pytest.approx(shown, rel=1e-12)
    assert conversion.symbol == symbol


@pytest.mark.parametrize("unit", ["", "1", "%", "s", "N*mm", "rad/(N*mm)", "kg", "mm2"])
def test_what_has_no_other_unit_stays_as_it_is(unit):
    assert INCH.conversion(unit) == Conversion(unit)
    assert INCH.conversion(unit).formatted(0.12345, ".3g") == "0.123"


def test_nothing_is_converted_for_who_reads_what_is_kept():
    texts = catalogue(ENGLISH)

    assert texts.units == KEPT
    assert texts.tag == "en"
    assert texts.say("length", length=millimetres(0.1234)) == "0.123 mm"


@pytest.mark.parametrize("kept_mm", [0.001, 0.0437, 1.2345, 812.7])
@pytest.mark.parametrize("decimals", [0, 1, 3, 4])
def test_a_shown_number_goes_back_to_the_kept_one_within_its_last_digit(kept_mm, decimals):
    kept = format(kept_mm, f".{decimals}f")
    shown = INCH.conversion("mm").formatted(float(kept), f".{decimals}f")

    assert abs(float(shown) * 25.4 - float(kept)) < 0.5 * 10.0**-decimals


def test_no_resolution_is_lost():
    assert INCH.conversion("mm").formatted(0.001, ".3f") == "0.00004"
    assert INCH.conversion("deg").formatted(0.01, ".2f") == "0.0002"
    assert INCH.conversion("°C").formatted(20.1, ".1f") == "68.2"


def test_printed_numbers_print_themselves_again():
    inch, rad = INCH.conversion("mm"), INCH.conversion("deg")

    assert INCH.printed(millimetres(0.12345)) == "0.00486"
    assert rounded(1.2345, 0.0254, "mm").shown(inch) == "0.0486"
    assert with_uncertainty(1.27, 0.0254).shown(inch) == "0.0500 ± 0.0010"
    assert interval(25.4, 50.8, 2.54).shown(inch) == "1.00 to 2.00"
    assert fixed(90.0, 2, "deg").shown(rad) == "1.5708"
    assert exact(254.0, "mm").shown(inch) == "10"


def test_a_dash_is_no_number():
    assert not isinstance(millimetres(math.nan), Printed)
    assert INCH.quantity(millimetres(math.nan), "mm").startswith("\N{EN DASH}")


def test_a_text_of_somebody_keeps_the_unit_it_was_written_in():
    words = catalogue("en-x-inch")

    assert words.say("front.bar.mean", value="0.1") == "mean 0.1 mm"


def test_a_tag_names_language_and_units_and_what_is_unknown_is_left_out():
    assert catalogue("fr-x-inch-rad-f").tag == "fr-x-inch-rad-f"
    assert catalogue("fr-x-mm").tag == "fr"
    assert Units.of(["furlong", "inch"]).chosen == ("inch", "deg", "c")


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_same_blanks_are_converted_in_every_language(language):
    english, texts = (catalogue(f"{one}-x-inch-rad-f")._texts for one in (ENGLISH, language))

    for key, text in english.items():
        blanks = dict(BLANKS.findall(text))
        theirs = dict(BLANKS.findall(texts[key]))
        assert {n: u for n, u in theirs.items() if n in blanks} == blanks or _in_um(theirs, blanks), key


def _in_um(theirs, blanks):
    """Whether they differ in the sign for micrometres alone."""
    return {name: unit.replace("\N{MICRO SIGN}", "u") for name, unit in theirs.items()} == blanks


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_text_names_a_unit_behind_a_number_that_it_does_not_convert(language):
    for key, text in catalogue(f"{language}-x-inch-rad-f")._texts.items():
        assert not re.search(
            r"(?:\}|\d) ?(?:mm|deg|grados(?! de libertad)|Grad)(?![\w/*])", _outside(text)
        ), key


def _outside(text):
    """Return a text without what blanks say of themselves."""
    return re.sub(r"\{[^}]*\|[^}]*\}", "", text)


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_number_of_a_list_knows_the_unit_that_stands_behind_the_last(language):
    for key, text in catalogue(f"{language}-x-inch-rad-f")._texts.items():
        assert not re.search(r"\{\w+:[^}|]*\df\}[,、 ]+\{[^}]*\|", text), key
