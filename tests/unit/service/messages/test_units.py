"""What is kept in mm, degrees and °C, in the units of a reader: of one number, and of every text there is."""

import math
import re
import string

import pytest

from tests.helpers.words.translations import every_text, texts
from truepose.messages.catalogue import ENGLISH, LANGUAGES, catalogue
from truepose.messages.units import KEPT, KNOWN, Conversion, ConvertibleNumber, Format, Units
from truepose.reports.rounding import (
    exact,
    format_fixed,
    format_rounded,
    interval,
    millimetres,
    with_uncertainty,
)

INCH = Units.of(["inch", "rad", "f"])
NAMED = re.compile(r"(?:^|_)(?<!_per_)(mm_per_h|deg_per_h|deg_per_k|mm|um|deg|c)$")
UNITS = {"mm_per_h": "mm/h", "deg_per_h": "deg/h", "deg_per_k": "deg/K", "c": "°C"}
WORDS = [
    "mm/h",
    "mm/s",
    "mm",
    "deg/h",
    "deg/K",
    "deg",
    "°C",
    "K",
    "\N{MICRO SIGN}m",
    "um",
    "Grad",
    "grados(?! de libertad)",
]
IN_WORDS = [  # with "um", and without: in German that is a preposition too
    re.compile(rf"(?:\}}|\d)[ \u00a0\u202f]?(?:{words})(?![\w/*\u00b7])|\[(?:{words})[\],;]")
    for words in ("|".join(WORDS), "|".join(word for word in WORDS if word != "um"))
]


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
    assert format_rounded(1.2345, 0.0254, "mm").shown(inch) == "0.0486"
    assert with_uncertainty(1.27, 0.0254).shown(inch) == "0.0500 ± 0.0010"
    assert interval(25.4, 50.8, 2.54).shown(inch) == "1.00 to 2.00"
    assert format_fixed(90.0, 2, "deg").shown(rad) == "1.5708"
    assert exact(254.0, "mm").shown(inch) == "10"


def test_a_dash_is_no_number():
    assert not isinstance(millimetres(math.nan), ConvertibleNumber)
    assert INCH.quantity(millimetres(math.nan), "mm").startswith("\N{EN DASH}")


def test_a_text_of_somebody_keeps_the_unit_it_was_written_in():
    words = catalogue("en-x-inch")

    assert words.say("front.bar.mean", value="0.1") == "mean 0.1 mm"


def test_a_tag_names_language_and_units_and_what_is_unknown_is_left_out():
    assert catalogue("fr-x-inch-rad-f").tag == "fr-x-inch-rad-f"
    assert catalogue("fr-x-mm").tag == "fr"
    assert Units.of(["furlong", "inch"]).chosen == ("inch", "deg", "c")


def test_a_format_states_the_unit_and_whether_the_word_for_it_follows():
    assert Format.of(".3f mm") == Format(".3f", "mm", is_named=True)
    assert Format.of(".3f (mm)") == Format(".3f", "mm")
    assert Format.of("deg/K") == Format("", "deg/K", is_named=True)
    assert Format.of("Capital") == Format("Capital")
    assert Format.of("") == Format("")


@pytest.mark.parametrize(
    ("tag", "said"),
    [
        ("en", "0.500 to 1.000 mm [deg] 20 °C, 0.15 mm"),
        ("en-x-inch-rad-f", "0.01969 to 0.03937 in [rad] 68 °F, 0.0059 in"),
    ],
)
def test_a_text_is_filled_in_with_quantities_in_the_readers_units(tag, said):
    text = "{low_mm:.3f (mm)} to {high_mm:.3f mm} [{deg}] {20:°C}, {0.15:mm}"

    assert catalogue(tag)._formatter.format(text, low_mm=0.5, high_mm=1.0) == said


def test_a_number_of_a_text_keeps_its_decimal_sign():
    assert catalogue("de")._formatter.format("{0,15:mm}") == "0,15 mm"
    assert catalogue("de-x-inch")._formatter.format("{0,15:mm}") == "0,0059 in"


def test_a_word_in_the_place_of_a_number_keeps_the_unit_it_was_written_in():
    assert catalogue("en-x-inch")._formatter.format("{value:mm}", value="a tenth of a") == "a tenth of a mm"


def quantities(text):
    """Return the blanks of a text that are of a unit, each with it; signs are a language's own."""
    parsed = string.Formatter().parse(text)
    stated = [
        (name, name if name in KNOWN else Format.of(spec or "").unit) for _, name, spec, _ in parsed if name
    ]
    return {(_alike(name), _alike(unit)) for name, unit in stated if unit}


def _alike(word):
    return word.replace("\N{MICRO SIGN}", "u").replace(",", ".")


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_states_the_same_units(language):
    english = texts(ENGLISH)

    for key, forms in texts(language).items():
        assert set().union(*map(quantities, forms)) == set().union(*map(quantities, english[key])), key


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_value_that_is_named_for_its_unit_states_it(language):
    for key, text in every_text(language):
        for name in re.findall(r"\{(\w+)", text):
            named = NAMED.search(name)
            assert not named or (name, UNITS.get(named[1], named[1])) in quantities(text), f"{key}: {name}"


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_unit_stands_in_the_words_behind_a_number(language):
    """What is per something, as `um_per_m` says of itself, is shown as it is kept."""
    words = IN_WORDS[language == "de"]
    for key, text in every_text(language):
        assert not words.search(re.sub(r"\{\w+_per_\w+[^}]*\}|(?<!\d)1 K", "", text)), key


@pytest.mark.parametrize("text", ["{off:.3f} mm", "5 deg", "residual [um]", "to {high:.1f}\u00a0°C"])
def test_a_unit_in_the_words_is_found(text):
    assert IN_WORDS[0].search(text)


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_number_of_a_list_states_the_unit_that_stands_behind_the_last(language):
    for key, text in every_text(language):
        assert not re.search(r"\{\w+:[^} ]*\df\}[,、 ]+\{\w+:\S+ [^}(]+\}", text), key


def test_micrometres_are_printed_with_their_sign_though_documents_keep_ascii():
    assert (KEPT.conversion("um").symbol, Units("inch").conversion("um").symbol) == ("\N{MICRO SIGN}m", "in")
