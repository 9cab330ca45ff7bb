"""The answer: findings with their words, rivals and gain, what is left, and the verdict."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from service import __version__
from service.diagnosis.curves import finding_curve, remaining_curve
from service.diagnosis.doubts import better_families, owed_to_the_rest
from service.diagnosis.groups import grouped, names_of
from service.diagnosis.held_out import Judged, Judging, gain_of
from service.diagnosis.left import Left, left_by
from service.diagnosis.line_orders import with_known_orders
from service.diagnosis.next_measurements import next_measurements
from service.diagnosis.open_shapes import with_open_shapes
from service.diagnosis.readings_found import readings_found
from service.diagnosis.remaining import Prepared, prepared_families
from service.diagnosis.rivals import Weighed, weighed
from service.diagnosis.ruled_out import ruled_out
from service.diagnosis.scene import scene_of
from service.diagnosis.selection import Propose, Selected, reselected, select
from service.diagnosis.start import NUISANCE, Start
from service.diagnosis.ways import worth_of
from service.diagnosis.wording import first_line, noise_of, remaining_sentence
from service.domain.campaign import Campaign
from service.domain.diagnosis import (
    Cause,
    Confidence,
    Dependence,
    Diagnosis,
    Finding,
    Gain,
    Remaining,
    Verdict,
    WorstPoint,
)
from service.domain.results import Model
from service.effects.causes import Candidate, Fitted, Scene, Shown
from service.effects.cells import cell_of
from service.effects.registry import CAUSES
from service.effects.tool_certificate import NAME as CERTIFICATE
from service.effects.unnamed.cause import NAME as UNNAMED
from service.identification.considered import considered
from service.identification.distributions import chi2_median
from service.identification.identify import nominal_fit
from service.identification.models import Fits, model_of
from service.identification.reference import ReferenceBlock
from service.identification.robust import RobustFit
from service.identification.robust import fit as refit
from service.identification.statistics import statistics

_FAR_BEYOND = 3.0  # times the stated noise: more than parameters leave that the data determine at all
_FAR_WORSE = 1.5  # times the largest error before: more than another draw of the noise does
# Of what is wrong: findings that explain less, beside what nothing explains, are not claimed.
_SMALL_PART = 0.2

Group = tuple[str, tuple[Candidate, ...]]
Tell = Callable[[float, str], None]


@dataclass(frozen=True, slots=True)
class _Tested:
    """A selection, with what unseen points and its own residuals say of it."""

    selected: Selected
    groups: tuple[Group, ...]
    judged: Judged
    families: tuple[Prepared, ...]
    left: Left


@dataclass(frozen=True, slots=True)
class _Answer:
    """What the parts of an answer are made from."""

    start: Start
    tested: _Tested  # doubts included in what is left
    scene: Scene  # of the extended model


def answered(
    start: Start, selected: Selected, propose: Propose, without: tuple[str, ...], tell: Tell
) -> Diagnosis:
    """Put everything that a diagnosis found together."""
    judging = Judging(start.campaign, start.fit, propose)
    withdrawn: tuple[str, ...] = ()
    refuted: frozenset[Cause] = frozenset()
    tested = _tested(start, selected, judging, without, refuted)
    while useless := _to_withdraw(start, tested):
        groups = tested.groups
        withdrawn += tuple(_withdrawal(start, tested, index) for index in useless)
        refuted |= {Cause(pick.effect, pick.subject) for index in useless for pick in groups[index][1]}
        kept = tuple(pick for k, (_, group) in enumerate(groups) if k not in useless for pick in group)
        if not kept and any(groups[index][1][0].effect == UNNAMED for index in useless):
            kept = _names_alone(start, propose)
        selected = reselected(start.fit, tested.selected, kept, propose)
        tested = _tested(start, selected, judging, without, refuted)
    tell(0.85, "putting it into words")
    left = replace(
        _with_doubts(tested),
        worse_unseen=_worse_unseen(tested.judged, start),
        worse_at=_worse_at(tested.judged),
    )
    scene = scene_of(start.problem, tested.selected.fit)
    return _told(_Answer(start, replace(tested, left=left), scene), withdrawn, without)


def _names_alone(start: Start, propose: Propose) -> tuple[Candidate, ...]:
    """Return what is found among causes with a name: a cell that does not help had stood in its place."""

    def named(fit: RobustFit) -> tuple[Candidate, ...]:
        return tuple(candidate for candidate in propose(fit) if candidate.effect != UNNAMED)

    return select(start.fit, named, lambda _share: None).picks


def _tested(
    start: Start, selected: Selected, judging: Judging, without: tuple[str, ...], refuted: frozenset[Cause]
) -> _Tested:
    groups = grouped(selected.picks)
    judged = judging.of(selected, tuple(group for _, group in groups))
    families = prepared_families(selected.fit, start.scene)
    return _Tested(selected, groups, judged, families, left_by(start, selected, families, without, refuted))


def _worse_unseen(judged: Judged, start: Start) -> float:
    """Return typical validation errors over the stated noise, where they are far beyond it; else 0.

    What the calibration points cannot show may be wrong all the same.
    """
    stated = start.problem.blocks[0].stated_sigma()
    if judged.source != "validation" or stated == 0.0:
        return 0.0
    squared = (judged.errors.after_mm**2).sum(axis=1) / stated**2
    ratio = float(np.sqrt(np.median(squared) / chi2_median(judged.errors.after_mm.shape[1])))
    return ratio if ratio > _FAR_BEYOND else 0.0


def _worse_at(judged: Judged) -> WorstPoint | None:
    """Return the worst held-out point where it is far worse than the worst one was without the findings.

    A mean that gets better hides it: a shape that fits where readings are may do anything in between.
    """
    largest_before_mm = float(np.linalg.norm(judged.errors.before_mm, axis=1).max())
    worst = judged.errors.worst
    limit_mm = max(_FAR_WORSE * largest_before_mm, largest_before_mm + 5.0 * judged.noise_mm)
    return worst if worst.after_mm > limit_mm else None


def _with_doubts(tested: _Tested) -> Left:
    """Add the families that tell the story of a finding better than its name."""
    selected, left = tested.selected, tested.left
    together: dict[Cause, tuple[Candidate, ...]] = {}
    for subject, group in tested.groups:
        cause = Cause(group[0].effect, subject)
        together[cause] = (*together.get(cause, ()), *group)
    better = tuple(
        one for group in together.values() for one in better_families(selected, group, tested.families)
    )
    known = {one.variable for one in left.depends}
    new = {one.variable: one for one in better if one.variable not in known}
    return replace(left, depends=(*left.depends, *new.values()))


def _useless(selected: Selected, groups: tuple[Group, ...], judged: Judged, left: Left) -> tuple[int, ...]:
    """Return the findings to withdraw: all where they do not help unseen points together, else single ones.

    While something is left that nothing explains, a finding may owe its place to it: then it is tested again
    beside that, and all of them together must explain a fair part of what is wrong.
    """
    if not groups:
        return ()
    gains = [judged.gain(index) for index in range(len(groups))]
    together = gain_of(judged.errors.before_mm, judged.errors.after_mm, judged.site)
    if together.interval_95_mm[0] <= 0.0 or (left.structure and _explains_little(together, judged)):
        return tuple(range(len(groups)))
    owed = owed_to_the_rest(selected, [group for _, group in groups], left)
    return tuple(
        index
        for index, gain in enumerate(gains)
        if gain.rms_before_mm <= gain.rms_after_mm or (owed[index] and _explains_little(gain, judged))
    )


def _to_withdraw(start: Start, tested: _Tested) -> tuple[int, ...]:
    """Return the findings that are not kept: those that do not help, and those that physics forbids."""
    useless = _useless(tested.selected, tested.groups, tested.judged, tested.left)
    forbidden = tuple(index for index in range(len(tested.groups)) if _forbidden(start, tested, index))
    return useless or forbidden


def _forbidden(start: Start, tested: _Tested, index: int) -> str:
    """Return why physics does not let a finding be kept, "" where it does."""
    shown = _shown(tested.selected, scene_of(start.problem, tested.selected.fit), *tested.groups[index])
    return shown.limits.why if shown.limits and shown.limits.withdrawn and shown.impossible else ""


def _explains_little(gain: Gain, judged: Judged) -> bool:
    """Whether it is a small part of what is wrong on unseen points that a gain takes away."""
    wrong = gain.rms_before_mm**2 - judged.noise_mm**2
    return gain.rms_before_mm**2 - gain.rms_after_mm**2 < _SMALL_PART * wrong


def _withdrawal(start: Start, tested: _Tested, index: int) -> str:
    (subject, picks), gain = tested.groups[index], tested.judged.gain(index)
    why = _forbidden(start, tested, index)
    if why:
        return f"{picks[0].effect} ({subject}) fits these readings and is withdrawn: {why}."
    return (
        f"{picks[0].effect} ({subject}) fits these readings and is withdrawn: on unseen points, or beside "
        "what nothing explains, it does not help beyond chance "
        f"(RMS {gain.rms_before_mm:.4f} mm without, {gain.rms_after_mm:.4f} mm with it)."
    )


def _told(answer: _Answer, withdrawn: tuple[str, ...], without: tuple[str, ...]) -> Diagnosis:
    start, tested = answer.start, answer.tested
    selected, judged, left = tested.selected, tested.judged, tested.left
    readings = readings_found(start, selected, left, judged)
    findings = (*_findings(answer), *(one for one in readings if one.effect not in without))
    remaining = Remaining(
        structure=left.structure,
        depends_on=tuple(
            Dependence(one.variable, one.p_value, remaining_curve(selected, start.scene, one))
            for one in left.depends
        ),
        sentence=remaining_sentence(left, full=selected.full),
        worse_at=left.worse_at,
    )
    verdict = _verdict(bool(findings), left.structure)
    before = statistics(judged.errors.before_mm, judged.noise_mm)
    after = statistics(judged.errors.after_mm, judged.noise_mm)
    found = frozenset(Cause(one.effect, one.subject) for one in findings)
    return Diagnosis(
        robot=start.campaign.robot.name,
        verdict=verdict,
        message=first_line(verdict, findings, before, after, remaining),
        start_effects=start.effects,
        findings=findings,
        quantity=start.problem.quantity,
        before=before,
        after=after,
        held_out="validation" if judged.source == "validation" else "cross_validation",
        remaining=remaining,
        next_measurements=next_measurements(start, selected, tested.groups, findings, left),
        ruled_out=ruled_out(start.scene, selected, found, without),
        withdrawn=withdrawn,
        noise=noise_of(left),
        errors=judged.errors,
        model=_model(answer),
    )


def _verdict(found: bool, structure: bool) -> Verdict:
    if found:
        return Verdict.PARTLY_EXPLAINED if structure else Verdict.EXPLAINED
    return Verdict.UNEXPLAINED if structure else Verdict.CONSISTENT


def _findings(answer: _Answer) -> tuple[Finding, ...]:
    structured = answer.tested.left.structure
    scales = [
        weighed(answer.tested.selected, group, structure_left=structured) for _, group in answer.tested.groups
    ]
    total = sum(scale.explained for scale in scales) or 1.0
    found = [_finding(answer, index, scale, scale.explained / total) for index, scale in enumerate(scales)]
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _finding(answer: _Answer, index: int, scale: Weighed, share: float) -> Finding:
    subject, group = answer.tested.groups[index]
    gain = answer.tested.judged.gain(index)
    shown = _shown(answer.tested.selected, answer.scene, subject, group)
    cell = cell_of(group[0]._replace(subject=subject))
    helps = gain.interval_95_mm[0] > 0.0 and not answer.tested.left.structure
    sure = helps and not scale.rivals and not shown.impossible
    return Finding(
        effect=group[0].effect,
        subject=shown.subject,
        amplitude=shown.amplitude,
        unit=shown.unit,
        amplitude_standard_uncertainty=shown.standard_uncertainty,
        p_value=scale.p_value,
        confidence=Confidence.CERTAIN if sure else Confidence.LIKELY,
        details=with_known_orders(answer.tested.selected, group, shown.details, answer.scene),
        sentence=_sentence(shown),
        confusable_with=scale.rivals,
        gain=gain,
        parameters=names_of(group),
        share=share,
        curve=finding_curve(answer.tested.selected, answer.start.scene, group),
        where=cell.where,
        over=cell.over,
        shape=cell.shape,
        worth=worth_of(answer.tested.selected, names_of(group)),
    )


def _sentence(shown: Shown) -> str:
    """Return what is said of a finding; beyond physical limits also that it cannot be what it says."""
    if shown.limits is None or not shown.impossible:
        return shown.sentence
    return f"{shown.sentence.removesuffix('.')}; {shown.limits.why}: something else acts here."


def _shown(selected: Selected, scene: Scene, subject: str, group: tuple[Candidate, ...]) -> Shown:
    fit = selected.fit
    names = names_of(group)
    rows = [fit.structure.index_of(name) for name in names]
    fitted = Fitted(names, fit.values[rows], fit.solution.covariance[np.ix_(rows, rows)])
    return CAUSES[group[0].effect].shown(subject, fitted, scene)


def _model(answer: _Answer) -> Model:
    """Return the extended model, fitted without what only the diagnosis needed."""
    start, full = answer.start, answer.tested.selected.fit
    structure = full.structure.without(NUISANCE)
    blocks = tuple(block for block in full.blocks if not isinstance(block, ReferenceBlock))
    if _acts_on_instrument(structure.effects):
        structure, blocks = full.structure.without((CERTIFICATE,)), full.blocks
    values = np.array([full.values[full.structure.index_of(name)] for name in structure.names])
    solution = refit(structure, blocks, values)
    plain = RobustFit(structure, blocks, solution, full.gross[: len(blocks)], full.chi2_per_dof)
    nominal = nominal_fit(start.problem, start.fit)
    honest = with_open_shapes(plain)
    fits = Fits(start.campaign, honest, nominal, considered(start.campaign, honest).total)
    return model_of(fits, discrepancy_mm=_discrepancy_mm(answer), program_version=__version__)


def _acts_on_instrument(effects: tuple[str, ...]) -> bool:
    return bool({"instrument_drift", "instrument_scale"} & set(effects))


def _discrepancy_mm(answer: _Answer) -> float:
    """Return what the usual held-out residuals show per axis beyond the readings' noise [mm]."""
    squared = (answer.tested.judged.errors.after_mm**2).mean(axis=1)
    usual = squared <= 25.0 * float(np.median(squared))
    noise = answer.start.problem.blocks[0].stated_sigma()
    return float(np.sqrt(max(float(squared[usual].mean()) - noise**2, 0.0)))


def unanswerable(campaign: Campaign, effects: tuple[str, ...], sentence: str) -> Diagnosis:
    """Return what is said where the present model cannot even be fitted."""
    position = campaign.calibration is not None
    return Diagnosis(
        robot=campaign.robot.name,
        verdict=Verdict.UNEXPLAINED,
        message=sentence,
        start_effects=effects,
        findings=(),
        quantity="position" if position else "length",
        before=None,
        after=None,
        held_out="validation",
        remaining=Remaining(True, (), sentence),
        next_measurements=(),
        ruled_out=(),
        withdrawn=(),
        noise=None,
        errors=None,
        model=None,
    )
