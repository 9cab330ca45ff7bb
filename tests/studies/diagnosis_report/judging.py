"""A diagnosis beside what was planted: named or not, doubted or not, how far off its amplitude."""

import math
from dataclasses import dataclass, replace

from tests.studies.diagnosis_report.planted.planting import Planted
from truepose.domain.diagnosis import Cause, Diagnosis, Finding, Verdict
from truepose.effects.causes import Candidate
from truepose.effects.signatures import signature_of
from truepose.effects.unclassified.cause import NAME as UNNAMED

_SAME_ORDER = 0.5  # orders of gears and encoders are whole numbers


@dataclass(frozen=True, slots=True)
class Named:
    """What became of one planted effect."""

    credit: float  # 1 named, 0.5 listed as confusable with what was named, 0 neither
    scores: tuple[float, ...] = ()  # (found less planted amplitude) over its stated uncertainty
    order_found: bool | None = None  # None: not a wave, or not named


@dataclass(frozen=True, slots=True)
class Outcome:
    """One diagnosis against the truth; what a table counts."""

    verdict: str
    named: tuple[Named, ...]  # in the order of what was planted
    found: tuple[str, ...]
    wrong: tuple[str, ...]  # findings that answer nothing planted, nor describe it rightly
    rivals: tuple[str, ...]
    depends_on: tuple[str, ...]
    structure_left: bool
    only_likely: bool  # some finding is no more than likely
    mean_before_mm: float
    mean_after_mm: float
    label: str = ""
    readings: int = 0
    seed: int = 0
    wall_s: float = math.nan
    fault: str = ""  # why there is no diagnosis

    @property
    def detected(self) -> bool:
        """Whether the diagnosis says that something is there."""
        return self.verdict not in {"", Verdict.CONSISTENT.value}

    @property
    def all_named(self) -> bool:
        """Whether everything planted is named."""
        return all(one.credit == 1.0 for one in self.named)

    @property
    def doubted(self) -> bool:
        """Whether a rival is given or structure is said to remain."""
        return bool(self.rivals) or self.structure_left


def judge(diagnosis: Diagnosis, planted: tuple[Planted, ...]) -> Outcome:
    """Return what the diagnosis says against what was planted."""
    answers = [_answers(effect, diagnosis.all_findings) for effect in planted]
    answering = {id(finding) for findings in answers for finding in findings}
    rivals = [rival for finding in diagnosis.all_findings for rival in finding.confusable_with]
    named = (_named(effect, found, rivals) for effect, found in zip(planted, answers, strict=True))
    return Outcome(
        verdict=diagnosis.verdict.value,
        named=tuple(named),
        found=tuple(_said(finding) for finding in diagnosis.all_findings),
        wrong=tuple(
            _said(f) for f in diagnosis.all_findings if id(f) not in answering and not _tells(f, planted)
        ),
        rivals=tuple(f"{rival.effect} ({rival.subject})" for rival in rivals),
        depends_on=tuple(one.variable for one in diagnosis.remaining.depends_on),
        structure_left=diagnosis.remaining.structure,
        only_likely=any(finding.confidence == "likely" for finding in diagnosis.all_findings),
        mean_before_mm=math.nan if diagnosis.before is None else diagnosis.before.mean_mm,
        mean_after_mm=math.nan if diagnosis.after is None else diagnosis.after.mean_mm,
    )


def failed(fault: str, planted: tuple[Planted, ...]) -> Outcome:
    """Return the outcome of a diagnosis that ended with an error."""
    nothing = Outcome("", (), (), (), (), (), False, False, math.nan, math.nan, fault=fault)
    return replace(nothing, named=tuple(Named(0.0) for _ in planted))


def _answers(planted: Planted, findings: tuple[Finding, ...]) -> list[Finding]:
    """Return the findings that name the effect; of several waves of the joint the one of its order."""
    named = [finding for finding in findings if Cause(finding.effect, finding.subject) in planted.right]
    if planted.order is None or len(named) < 2:
        return named
    same = [finding for finding in named if _has_order(finding, planted.order)]
    return (same or named)[:1]


def _tells(finding: Finding, planted: tuple[Planted, ...]) -> bool:
    """Whether a cause without a name says rightly where something planted acts, or over what."""
    if finding.effect != UNNAMED:
        return False
    causes = (cause for effect in planted for cause in effect.right)
    cells = [signature_of(Candidate(cause.effect, cause.subject, ())) for cause in causes]
    return any(finding.where == cell.where or finding.over == cell.over for cell in cells)


def _named(planted: Planted, found: list[Finding], rivals: list[Cause]) -> Named:
    if not found:
        return Named(0.5 if any(rival in planted.right for rival in rivals) else 0.0)
    scores = (_score(finding, planted.right[Cause(finding.effect, finding.subject)]) for finding in found)
    order = planted.order
    return Named(
        credit=1.0,
        scores=tuple(score for score in scores if score is not None),
        order_found=None if order is None else any(_has_order(finding, order) for finding in found),
    )


def _score(finding: Finding, true: float | None) -> float | None:
    uncertainty = finding.amplitude_standard_uncertainty
    return None if true is None or uncertainty <= 0.0 else (finding.amplitude - true) / uncertainty


def _has_order(finding: Finding, order: float) -> bool:
    orders = (detail.value for detail in finding.details if detail.name.startswith("order"))
    return any(abs(found - order) < _SAME_ORDER for found in orders)


def _said(finding: Finding) -> str:
    return f"{finding.effect} ({finding.subject})"
