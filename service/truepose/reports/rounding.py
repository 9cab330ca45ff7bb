"""Numbers as a reader expects them: uncertainties to two digits, values to the same place.

GUM (JCGM 100:2008), 7.2.6: at most two significant digits of an uncertainty.
"""

import math

MISSING = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"
_SMALLEST_PLAIN = 1e-4  # below this, numbers are written with a power of ten
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_EXACT_DECIMALS = 9  # rounding of pi / 2 and the like stays below; no drawing goes there


def millimetres(value_mm: float) -> str:
    """Return a length without unit: three significant digits, 0.1 um at the finest."""
    if not math.isfinite(value_mm):
        return MISSING
    decimals = 4 if abs(value_mm) < 0.1 else 3 if abs(value_mm) < 10.0 else 2
    return _signed(f"{value_mm:.{decimals}f}")


def uncertainty(value: float) -> str:
    """Return an uncertainty with two significant digits."""
    return rounded(value, value)


def rounded(value: float, standard_uncertainty: float) -> str:
    """Return `value` to the second digit of its uncertainty; four significant digits where there is none."""
    if not math.isfinite(value):
        return MISSING
    if not math.isfinite(standard_uncertainty) or standard_uncertainty <= 0.0:
        return f"{value:.4g}"
    if standard_uncertainty < _SMALLEST_PLAIN:
        return _scientific(value, standard_uncertainty)
    return _signed(f"{value:.{max(decimals_of(standard_uncertainty), 0)}f}")


def with_uncertainty(value: float, standard_uncertainty: float) -> str:
    """Return "value ± uncertainty" as printed; small ones share one power of ten."""
    if not math.isfinite(standard_uncertainty) or standard_uncertainty <= 0.0 or not math.isfinite(value):
        return rounded(value, standard_uncertainty)
    return _joined((value, standard_uncertainty), standard_uncertainty, " ± ")


def interval(low: float, high: float, standard_uncertainty: float, to: str = "to") -> str:
    """Return "low to high" with the digits that a standard uncertainty above 0 allows."""
    return _joined((low, high), standard_uncertainty, f" {to} ")


def _joined(values: tuple[float, float], standard_uncertainty: float, word: str) -> str:
    if standard_uncertainty >= _SMALLEST_PLAIN:
        return word.join(_printed(rounded(value, standard_uncertainty)) for value in values)
    exponent = math.floor(math.log10(max(*map(abs, values), standard_uncertainty)))
    decimals = max(decimals_of(standard_uncertainty) + exponent, 0)
    mantissas = word.join(_printed(_signed(f"{value / 10.0**exponent:.{decimals}f}")) for value in values)
    return f"({mantissas}) {_TIMES} 10{str(exponent).translate(_RAISED)}"


def _printed(number: str) -> str:
    return number.replace("-", MINUS)


def exact(value: float) -> str:
    """Return a value that has no uncertainty, such as a nominal one, with the digits it was given with."""
    return _signed(f"{round(value, _EXACT_DECIMALS):.10g}")


def _signed(text: str) -> str:
    """Return the number without the sign of a zero."""
    return text.removeprefix("-") if not text.strip("-0.") else text


def decimals_of(standard_uncertainty: float) -> int:
    """Return the decimals that show two significant digits of an uncertainty above 0."""
    # Rounding first: 0.0996 is 0.10 to two digits, one place fewer than its exponent says.
    return 1 - math.floor(math.log10(float(f"{standard_uncertainty:.1e}")))


def _scientific(value: float, standard_uncertainty: float) -> str:
    exponent = math.floor(math.log10(max(abs(value), standard_uncertainty)))
    decimals = max(decimals_of(standard_uncertainty) + exponent, 0)
    return f"{value / 10.0**exponent:.{decimals}f}e{exponent:+03d}"


def p_value(probability: float) -> str:
    """Return a p-value; what is too small to mean a digit is said to be small."""
    return "< 0.0001" if probability < 1e-4 else f"{probability:.2g}"
