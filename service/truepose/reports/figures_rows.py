"""The table of figures: what a reader compares of an identification, row by row."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.results import Identification, NominalAndIdentified
from truepose.identification.verdict.judge import Judged
from truepose.reports.uncertainty.judged import FAR_OUT, without_far_out


@dataclass(frozen=True, slots=True)
class FiguresRow:
    """One block of the table of figures."""

    label: str
    remark: str
    pair: NominalAndIdentified


def _positions_rows(identification: Identification) -> Iterator[FiguresRow]:
    """Yield how a model of lengths does on held-out positions."""
    positions = identification.positions
    if positions is None:
        return
    if positions.tied is not None:
        remark = "held out positions, the frame tied by the measured base cups"
        yield FiguresRow("Positions", remark, positions.tied)
    remark = "held out positions, after the best rigid alignment"
    yield FiguresRow("Positions, aligned", remark, positions.aligned)


def figures_rows(identification: Identification, shown: Judged | None) -> Iterator[FiguresRow]:
    """Yield the statistics that a reader compares, with and without what lies far out."""
    if identification.validation is not None:
        yield FiguresRow(
            "Validation", "held out: the model never saw these readings", identification.validation
        )
        further = None if shown is None else without_far_out(shown)
        if further is not None:
            pair, dropped = further
            remark = (
                f"the same without {dropped} beyond {FAR_OUT:g} times the median error, for comparison only"
            )
            yield FiguresRow("Validation, without far readings", remark, pair)
    elif identification.cross_validation is not None:
        remark = "by configuration: each predicted by a model that never saw it"
        yield FiguresRow("Cross-validation", remark, identification.cross_validation)
    yield from _positions_rows(identification)
    if identification.calibration is not None:
        yield FiguresRow(
            "Calibration", "all readings that the model was made from", identification.calibration
        )
    if identification.calibration_without_outliers is not None:
        remark = f"without the {identification.counts.outliers} given no weight"
        yield FiguresRow("Calibration, without outliers", remark, identification.calibration_without_outliers)
