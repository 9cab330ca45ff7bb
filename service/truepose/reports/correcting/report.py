"""The report of a corrected file: how many targets, how well, which not, and which file came of which."""

from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from truepose.domain.results.corrections import CorrectedTargets, FileCorrection
from truepose.reports.corrected_targets import target_heads, target_rows
from truepose.reports.corrections import correction_sentences
from truepose.reports.figures.maps.shift_map import shift_map
from truepose.reports.front.page import Front, OneFigure, front_page, graded
from truepose.reports.pages import rendered
from truepose.reports.traceability.conditions import ReportConditions
from truepose.reports.traceability.imprint import imprint_of
from truepose.reports.wording.rounding import uncertainty_mm
from truepose.words.catalogue import Catalogue, catalogue

_MOST_ROWS: Final = 500  # of targets on paper; the corrected file has all


@dataclass(frozen=True, slots=True)
class CorrectionInput:
    """What a report of a correction is made from."""

    name: str  # of the file
    robot: str
    correction: FileCorrection
    targets: CorrectedTargets
    hashes: tuple[str, str]  # SHA-256 of the file before and after
    conditions: ReportConditions
    language: str


def correction_page(report: CorrectionInput) -> Markup:
    """Return the report as one self-contained page."""
    words, found = catalogue(report.language), report.correction
    sentences = tuple(map(words.spoken, correction_sentences(found.totals)))
    drawn = shift_map(report.targets, words)
    return rendered(
        "correction_report.html",
        words=words,
        say=words.say,
        report=report,
        front=front_page(_front(report, sentences[0], words), report.conditions, words),
        imprint=imprint_of(report.robot, report.conditions, words),
        simulated=report.conditions.simulated,
        conditions=report.conditions,
        sentences=sentences,
        cautions=tuple(map(words.spoken, found.cautions)),
        drawn=drawn,
        heads=target_heads(words),
        rows=tuple(target_rows(report.targets, words, 0, _MOST_ROWS)),
        total=len(report.targets.names),
    )


def _front(report: CorrectionInput, sentence: str, words: Catalogue) -> Front:
    totals = report.correction.totals
    whole = totals.solved == totals.targets > 0 and not report.correction.left_alone
    figure = None
    if totals.solved:
        largest = words.units.quantity(uncertainty_mm(totals.largest_uncertainty_mm), "mm")
        figure = OneFigure(
            words.say("front.correction.uncertainty"), largest, words.say("front.correction.u")
        )
    return Front(
        title=words.say("correct.of", name=report.name),
        look=graded(True) if whole else "partly_explained" if totals.solved else graded(False),
        word=words.say("front.correction.whole" if whole else "front.correction.part"),
        sentence=sentence,
        robot=report.robot,
        figure=figure,
        rule=words.say("front.correction.prove"),
    )
