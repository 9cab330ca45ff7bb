"""Numbers of several answers as text: one way to write a size, a change, a count."""

from collections.abc import Iterable, Iterator

from markupsafe import Markup

from truepose.domain.results.diagnosis import Finding
from truepose.domain.results.identification import NominalAndIdentified, Parameter, Statistics
from truepose.exchange.models.document import file_factor, file_unit
from truepose.notebook.shown import html
from truepose.reports.wording.causes import printed_unit
from truepose.reports.wording.rounding import MISSING, millimetres, rounded, uncertainty, with_uncertainty
from truepose.words.catalogue import english

STATISTICS = ("readings", "model", "n", "mean", "rms", "sd", "max", "noise")


def change(pair: NominalAndIdentified) -> str:
    """Return the RMS error before and after, e.g. `RMS 0.743 -> 0.0304 mm`."""
    return change_of(pair.nominal, pair.identified)


def change_of(before: Statistics, after: Statistics) -> str:
    """Return the RMS error before and after."""
    return f"RMS {millimetres(before.rms_mm)} -> {millimetres(after.rms_mm)} mm"


def counted(number: int, one: str, many: str | None = None) -> str:
    """Return a number of things: `no outlier`, `1 outlier`, `2 outliers`."""
    return f"{number or 'no'} {one if number in {0, 1} else many or one + 's'}"


def rows_of(label: str, before: str, after: str, pair: NominalAndIdentified) -> Iterator[tuple[str, ...]]:
    """Yield two rows of a table of errors [mm]."""
    for first, model, figures in ((label, before, pair.nominal), ("", after, pair.identified)):
        values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
        yield (first, model, str(figures.n), *map(millimetres, values))


def parameter_table(parameters: Iterable[Parameter]) -> Markup:
    """Return the table of parameters: values and standard uncertainties as documents state them."""
    head = ("parameter", "unit", "value", "u")
    rows = map(_parameter, parameters)
    return html.table("Parameters, added to the nominal values", head, rows, numbers_from=2)


def _parameter(parameter: Parameter) -> tuple[str, ...]:
    factor = file_factor(parameter.unit)
    u = parameter.standard_uncertainty * factor
    return parameter.name, file_unit(parameter.unit), rounded(parameter.value * factor, u), uncertainty(u)


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
