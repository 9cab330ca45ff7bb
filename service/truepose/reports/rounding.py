"""Numbers as a reader expects them: uncertainties to two digits, values to the same place.

GUM (JCGM 100:2008), 7.2.6: at most two significant digits of an uncertainty. Each is printed as it is kept,
and can print itself again in the unit of a reader.
"""

import math
from collections.abc import Callable

from truepose.messages.units import ConvertibleNumber, length_form

MISSING = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"
_SMALLEST_PLAIN = 1e-4  # below this, numbers are written with a power of ten
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_EXACT_DECIMALS = 9  # rounding of pi / 2 and the like stays below; no drawing goes there


def millimetres(value_mm: float) -> str:
    """Return a length without unit, with the digits that sentences show too (`length_form`)."""
    if not math.isfinite(value_mm):
        return MISSING
    form = length_form(value_mm)
    return ConvertibleNumber(lambda shown: _signed(shown.formatted(value_mm, form)), "mm")


def with_minus(number: str) -> str:
    """Return a number with a proper minus sign."""
    if not isinstance(number, ConvertibleNumber):
        return number
    return ConvertibleNumber(lambda shown: _printed(number.shown(shown)), number.unit)


def format_fixed(value: float, decimals: int, unit: str) -> str:
    """Return a value with as many decimals as its unit is worth."""
    if not math.isfinite(value):
        return MISSING
    return ConvertibleNumber(lambda shown: _signed(shown.formatted(value, f".{decimals}f")), unit)


def uncertainty(value: float, unit: str = "") -> str:
    """Return an uncertainty with two significant digits."""
    return format_rounded(value, value, unit)


def uncertainty_mm(value_mm: float) -> str:
    """Return the uncertainty of a length, without unit."""
    return uncertainty(value_mm, "mm")


def format_rounded(value: float, standard_uncertainty: float, unit: str = "") -> str:
    """Return `value` to the second digit of its uncertainty; four significant digits where there is none."""
    return _again(_rounded, (value,), standard_uncertainty, unit)


def _again(
    written: Callable[..., str], values: tuple[float, ...], standard_uncertainty: float, unit: str = ""
) -> str:
    """Return values that `written` writes with their uncertainty, in any unit."""
    if not all(map(math.isfinite, values)):
        return written(*values, standard_uncertainty)
    return ConvertibleNumber(
        lambda shown: written(*map(shown.of, values), shown.factor * standard_uncertainty), unit
    )


def _rounded(value: float, standard_uncertainty: float) -> str:
    if not math.isfinite(value):
        return MISSING
    if not math.isfinite(standard_uncertainty) or standard_uncertainty <= 0.0:
        return f"{value:.4g}"
    if standard_uncertainty < _SMALLEST_PLAIN:
        return _scientific(value, standard_uncertainty)
    return _signed(f"{value:.{max(decimals_of(standard_uncertainty), 0)}f}")


def with_uncertainty(value: float, standard_uncertainty: float, unit: str = "") -> str:
    """Return "value ± uncertainty" as printed; small ones share one power of ten."""
    return _again(_with_uncertainty, (value,), standard_uncertainty, unit)


def _with_uncertainty(value: float, standard_uncertainty: float) -> str:
    if not math.isfinite(standard_uncertainty) or standard_uncertainty <= 0.0 or not math.isfinite(value):
        return _rounded(value, standard_uncertainty)
    return _joined((value, standard_uncertainty), standard_uncertainty, " ± ")


def interval(low: float, high: float, standard_uncertainty: float, to: str = "to") -> str:
    """Return "low to high" with the digits that a standard uncertainty above 0 allows."""
    return _again(lambda *ends: _joined(ends[:2], ends[2], f" {to} "), (low, high), standard_uncertainty)


def _joined(values: tuple[float, float], standard_uncertainty: float, word: str) -> str:
    if standard_uncertainty >= _SMALLEST_PLAIN:
        return word.join(_printed(_rounded(value, standard_uncertainty)) for value in values)
    exponent = math.floor(math.log10(max(*map(abs, values), standard_uncertainty)))
    decimals = max(decimals_of(standard_uncertainty) + exponent, 0)
    mantissas = word.join(_printed(_signed(f"{value / 10.0**exponent:.{decimals}f}")) for value in values)
    return f"({mantissas}) {_TIMES} 10{str(exponent).translate(_RAISED)}"


def _printed(number: str) -> str:
    return number.replace("-", MINUS)


def exact(value: float, unit: str = "") -> str:
    """Return a value that has no uncertainty, such as a nominal one, with the digits it was given with."""
    return ConvertibleNumber(lambda shown: _signed(f"{round(shown.of(value), _EXACT_DECIMALS):.10g}"), unit)


def _signed(text: str) -> str:
    """Return the number without the sign of a zero."""
    return text.removeprefix("-") if not text.strip("-0.,") else text


def decimals_of(standard_uncertainty: float) -> int:
    """Return the decimals that show two significant digits of an uncertainty above 0."""
    # Rounding first: 0.0996 is 0.10 to two digits, one place fewer than its exponent says.
    return 1 - math.floor(math.log10(float(f"{standard_uncertainty:.1e}")))


def _scientific(value: float, standard_uncertainty: float) -> str:
    exponent = math.floor(math.log10(max(abs(value), standard_uncertainty)))
    decimals = max(decimals_of(standard_uncertainty) + exponent, 0)
    return f"{value / 10.0**exponent:.{decimals}f}e{exponent:+03d}"


def p_value(probability: float, equals: str = "") -> str:
    """Return a p-value behind `equals`; of one that is too small to mean a digit, that it is smaller."""
    return ConvertibleNumber(lambda _: "< 0.0001" if probability < 1e-4 else f"{equals}{probability:.2g}")
