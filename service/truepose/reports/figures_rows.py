"""The table of figures: what a reader compares of an identification, row by row."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.results.identification import Identification, NominalAndIdentified
from truepose.domain.sentences import Sentence, said
from truepose.identification.verdict.judge import Judged
from truepose.reports.uncertainty.judged import FAR_OUT, without_far_out


@dataclass(frozen=True, slots=True)
class FiguresRow:
    """One block of the table of figures."""

    label: Sentence
    remark: Sentence
    pair: NominalAndIdentified


def _positions_rows(identification: Identification) -> Iterator[FiguresRow]:
    """Yield how a model of lengths does on held-out positions."""
    positions = identification.positions
    if positions is None:
        return
    if positions.tied is not None:
        yield FiguresRow(said("figures.positions"), said("figures.positions.remark"), positions.tied)
    remark = said("figures.positions_aligned.remark")
    yield FiguresRow(said("figures.positions_aligned"), remark, positions.aligned)


def figures_rows(identification: Identification, shown: Judged | None) -> Iterator[FiguresRow]:
    """Yield the statistics that a reader compares, with and without what lies far out."""
    if identification.validation is not None:
        remark = said("figures.validation.remark")
        yield FiguresRow(said("figures.validation"), remark, identification.validation)
        further = None if shown is None else without_far_out(shown)
        if further is not None:
            pair, dropped = further
            remark = said("figures.validation.near.remark", dropped=dropped, times=FAR_OUT)
            yield FiguresRow(said("figures.validation.near"), remark, pair)
    elif identification.cross_validation is not None:
        remark = said("figures.cross_validation.remark")
        yield FiguresRow(said("figures.cross_validation"), remark, identification.cross_validation)
    if identification.relative is not None:
        yield FiguresRow(said("figures.relative"), said("figures.relative.remark"), identification.relative)
    yield from _positions_rows(identification)
    if identification.calibration is not None:
        remark = said("figures.calibration.remark")
        yield FiguresRow(said("figures.calibration"), remark, identification.calibration)
    if identification.calibration_without_outliers is not None:
        remark = said("figures.calibration.near.remark", outliers=identification.counts.outliers)
        without = identification.calibration_without_outliers
        yield FiguresRow(said("figures.calibration.near"), remark, without)
