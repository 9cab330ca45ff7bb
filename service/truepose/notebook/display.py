"""How a notebook displays answers: as DataFrames, small tables and text."""

import io
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from truepose.domain.diagnosis import Finding
from truepose.domain.identification import NominalAndIdentified, Parameter, Statistics
from truepose.exchange.models.document import file_factor, file_unit
from truepose.messages.catalogue import english
from truepose.notebook.errors import MissingExtraError
from truepose.reports.cause_words import printed_unit
from truepose.reports.rounding import MISSING, format_rounded, millimetres, uncertainty, with_uncertainty

if TYPE_CHECKING:
    from pandas import DataFrame


def frame(rows: object) -> "DataFrame":
    """Return a DataFrame of a list of rows, or of columns by name; raises MissingExtraError."""
    _require_pandas()
    from pandas import DataFrame

    return DataFrame(rows)


def frame_of_text(table: str) -> "DataFrame":
    """Return the DataFrame of a CSV text; raises MissingExtraError."""
    _require_pandas()
    from pandas import read_csv

    return read_csv(io.StringIO(table))


def _require_pandas() -> None:
    try:
        import pandas  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "A DataFrame needs pandas, which is not installed: pip install 'truepose[notebook]'."
        ) from error


_TABLE = Markup("<table><caption>{}</caption><thead><tr>{}</tr></thead><tbody>{}</tbody></table>")
_MOST_ROWS = 10  # of a table that has as many as the data
_LEFT, _RIGHT = Markup('style="text-align: left"'), Markup('style="text-align: right"')


def page(*parts: Markup) -> str:
    """Return the parts as what a notebook shows of one value."""
    return str(Markup("<div>{}</div>").format(Markup("").join(parts)))


def paragraphs(sentences: Iterable[str]) -> Markup:
    """Return each sentence as a paragraph."""
    return Markup("").join(Markup("<p>{}</p>").format(sentence) for sentence in sentences)


def table(
    caption: str, head: Sequence[str], rows: Iterable[Sequence[str]], *, numbers_from: int = 1
) -> Markup:
    """Return a table of texts; columns from `numbers_from` on, counted from 0, are aligned to the right."""
    names = _cells(head, "th", numbers_from)
    lines = Markup("").join(Markup("<tr>{}</tr>").format(_cells(row, "td", numbers_from)) for row in rows)
    return _TABLE.format(caption, names, lines)


def first_rows(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Markup:
    """Return a table of numbers as long as a notebook has room for, and say how many rows are left."""
    left = len(rows) - _MOST_ROWS
    more = [f"and {left} more rows"] if left > 0 else []
    return table("", head, rows[:_MOST_ROWS], numbers_from=0) + paragraphs(more)


def _cells(texts: Sequence[str], tag: str, numbers_from: int) -> Markup:
    return Markup("").join(
        Markup("<{0} {1}>{2}</{0}>").format(Markup(tag), _LEFT if k < numbers_from else _RIGHT, escape(text))
        for k, text in enumerate(texts)
    )


STATISTICS = ("readings", "model", "n", "mean", "rms", "sd", "max", "noise")


def change(pair: NominalAndIdentified) -> str:
    """Return the RMS error before and after, e.g. `RMS 0.743 -> 0.0304 mm`."""
    return change_of(pair.nominal, pair.identified)


def change_of(before: Statistics, after: Statistics) -> str:
    """Return the RMS error before and after."""
    return f"RMS {millimetres(before.rms_mm)} -> {millimetres(after.rms_mm)} mm"


def count_text(number: int, one: str) -> str:
    """Return a number of things: `no outlier`, `1 outlier`, `2 outliers`."""
    return f"{number or 'no'} {one if number in {0, 1} else one + 's'}"


def rows_of(label: str, before: str, after: str, pair: NominalAndIdentified) -> Iterator[tuple[str, ...]]:
    """Yield two rows of a table of errors [mm]."""
    for first, model, figures in ((label, before, pair.nominal), ("", after, pair.identified)):
        values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
        yield (first, model, str(figures.n), *map(millimetres, values))


def parameter_table(parameters: Iterable[Parameter]) -> Markup:
    """Return the table of parameters: values and standard uncertainties as documents state them."""
    head = ("parameter", "unit", "value", "u")
    rows = map(_parameter, parameters)
    return table("Parameters, as corrections to the nominal values", head, rows, numbers_from=2)


def _parameter(parameter: Parameter) -> tuple[str, ...]:
    factor = file_factor(parameter.unit)
    u = parameter.standard_uncertainty * factor
    return (
        parameter.name,
        file_unit(parameter.unit),
        format_rounded(parameter.value * factor, u),
        uncertainty(u),
    )


def finding_texts(number: int, finding: Finding) -> tuple[str, ...]:
    """Return the row of a finding: number, sentence, confidence, amplitude, RMS without and with it."""
    amplitude = with_uncertainty(finding.amplitude, finding.amplitude_standard_uncertainty)
    gain = finding.gain
    errors = (
        (MISSING, MISSING)
        if gain is None
        else (millimetres(gain.rms_before_mm), millimetres(gain.rms_after_mm))
    )
    size = f"{amplitude} {printed_unit(finding.unit)}".rstrip()
    return str(number), english(finding.sentence), finding.confidence.value, size, *errors
