"""The answer: findings with their words, rivals and gain, what is left, and the verdict.

Which findings are kept was decided before, within the calibration (`confidence.standing`). The validation
readings are used here for the first time, and once (decision 0031). They give the figures and the confidence.
They may withhold a description; where they contradict all findings, the model given out is the initial model.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.alternatives import RivalComparison, ruled_out, weigh_alternatives
from truepose.diagnosis.baseline_fit import NUISANCE, Start, scene_of
from truepose.diagnosis.confidence import (
    SelectionTests,
    better_families,
    split_by_size,
    standing,
    with_open_shapes,
)
from truepose.diagnosis.curves import (
    ValidationFit,
    curve_with_unseen,
    finding_curve,
    finding_spectrum,
    remaining_curve,
    unseen_of,
)
from truepose.diagnosis.evidence.held_out_errors import (
    CrossValidation,
    Improvement,
    nominal_errors,
    on_validation,
)
from truepose.diagnosis.evidence.residual_structure import (
    Relation,
    Remainder,
    fixed_nests_contradict,
    instrument_suspects,
)
from truepose.diagnosis.evidence.sensitivities import CompleteModel, description_of, worth_of
from truepose.diagnosis.evidence.signature_functions import signatures_in_data
from truepose.diagnosis.next_measurements import next_measurements
from truepose.diagnosis.reading_faults import shared_properties
from truepose.diagnosis.reading_findings import readings_found
from truepose.diagnosis.scatter import ScatterModel, telling_scatter
from truepose.diagnosis.screening.refinement import with_known_orders
from truepose.diagnosis.screening.selection import Choice, Propose, Selection, names_of, refit_picks
from truepose.diagnosis.sentences import first_line, noise_of, remaining_sentence
from truepose.domain.campaign import Campaign
from truepose.domain.diagnosis import (
    Cause,
    Confidence,
    Dependence,
    Diagnosis,
    Finding,
    Remaining,
    Verdict,
    WorstPoint,
)
from truepose.domain.identification import Model
from truepose.effects.causes import Candidate, Description, Scene
from truepose.effects.frames.tool_certificate import NAME as CERTIFICATE
from truepose.effects.signatures import of_instrument, signature_of
from truepose.identification.fit.assessment import propagate_certificates
from truepose.identification.fit.inadequacy import shortfall, typical_mm
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.robust import fit as refit
from truepose.identification.identify import nominal_fit
from truepose.identification.model_of_fit import Fits, model_of
from truepose.identification.verdict.judge import USUAL, statistics
from truepose.messages.message import Text, message, together
from truepose.version import __version__

_BEYOND = 1.5  # typical validation error over what explains it: more than a common error of the parameters
_FAR_WORSE = 1.5  # times the largest error before: more than another draw of the noise does

Tell = Callable[[float, Text], None]


@dataclass(frozen=True, slots=True)
class _Answer:
    """What the parts of an answer are made from.

    Attributes
    ----------
    start : Start
    tested : SelectionTests
        Doubts included in what is left.
    whole : CompleteModel or None
        None: the findings are all that the model is extended by.
    judged : Improvement
        On validation readings, where there are any; else in the folds.
    folds : Improvement
        Of the model in the end, chosen anew in each.
    scene : Scene
        Of the extended model.
    unseen : ValidationFit or None
        The extended model at validation readings, where there are any.
    """

    start: Start
    tested: SelectionTests
    whole: CompleteModel | None
    judged: Improvement
    folds: Improvement
    scene: Scene
    unseen: ValidationFit | None

    @property
    def found(self) -> RobustFit:
        """The fit with the findings, none that validation readings contradict."""
        return self.start.fit if self.tested.left.contradicted else self.tested.selected.fit

    @property
    def end(self) -> RobustFit:
        """The fit of the model that may be used."""
        return self.found if self.whole is None or self.tested.left.contradicted else self.whole.fit


def assemble_answer(
    start: Start,
    first: Choice,
    selected: Selection,
    propose: Propose,
    without: tuple[str, ...],
    tell: Tell,
) -> tuple[Diagnosis, ScatterModel | None]:
    """Put everything that a diagnosis found together.

    Parameters
    ----------
    start : Start
    first : Choice
        From the linearisation at the start; the folds choose anew from it.
    selected : Selection
        What was found in the end.
    propose : callable
        From a fit to every way in which it may still be wrong.
    without : tuple of str
        Causes that are left out of the library.
    tell : callable
        Told the fraction done, from 0.85, and what is being done.

    Returns
    -------
    Diagnosis
    ScatterModel or None
        On what the scatter of the readings depends beside all that.
    """
    judging = CrossValidation(first)
    tested, withdrawn = standing(start, selected, judging, propose, without)
    tell(0.85, message("job.doing.wording"))
    tested = replace(tested, left=_with_doubts(tested))
    whole = _whole(start, tested, judging)
    folds = _in_folds(tested, judging, whole)
    judged = _judged(start, tested, folds, whole)
    withheld = judged.described if _foretells_worse(judged) else None
    # Cross-validation favoured it, and yet it may predict validation readings worse (0.150 -> 0.172 mm seen).
    if withheld is not None:
        whole, folds = None, tested.judged
        judged = _judged(start, tested, folds, whole)
    left = replace(
        _with_shared(start, tested.left),
        worse_unseen=judged.beyond if judged.beyond > _BEYOND else 0.0,
        worse_at=_worse_at(judged),
        withheld=withheld,
        contradicted=_contradicts(judged, tested),
    )
    scene = scene_of(start.problem, tested.selected.fit)
    unseen = unseen_of(start, tested.selected)
    answer = _Answer(start, replace(tested, left=left), whole, judged, folds, scene, unseen)
    return _told(answer, withdrawn, without), telling_scatter(answer.end, start.campaign)


def _whole(start: Start, tested: SelectionTests, judging: CrossValidation) -> CompleteModel | None:
    """Return the model with what is left described too, where configurations left out ask for it.

    What is left over time is not foretold by a description of where the arm was when.
    """
    in_time = any(one.kind == "time" for one in tested.left.depends)
    groups = tuple(group for _, group in tested.groups)
    if in_time or not (tested.left.structure and judging.asks_for_description(groups)):
        return None
    found = signatures_in_data(tested.selected.pool, tested.selected.picks)
    return CompleteModel(refit_picks(start.fit, tested.selected.fit, found.candidates), found.candidates)


def _in_folds(tested: SelectionTests, judging: CrossValidation, whole: CompleteModel | None) -> Improvement:
    """Return what configurations left out say of the model in the end."""
    if whole is None:
        return tested.judged
    return judging.of(tested.selected, tuple(group for _, group in tested.groups), described=True)


def _judged(
    start: Start, tested: SelectionTests, folds: Improvement, whole: CompleteModel | None
) -> Improvement:
    """Return how the model in the end is judged: by validation readings, else by the folds."""
    groups = tuple(group for _, group in tested.groups)
    end = whole.fit if whole else tested.selected.fit
    return on_validation(start.campaign, (start.fit, end), tested.selected, groups) or folds


def _foretells_worse(judged: Improvement) -> bool:
    """Whether validation readings are foretold no better with a description than without it."""
    gain = judged.described
    return gain is not None and judged.source == "validation" and gain.rms_before_mm <= gain.rms_after_mm


def _contradicts(judged: Improvement, tested: SelectionTests) -> bool:
    """Whether validation readings are foretold no better with the findings than without them.

    In the folds little help is no reason: four fifths may miss what all readings show (decision 0031).
    """
    gain = judged.together
    return judged.source == "validation" and bool(tested.groups) and gain.rms_before_mm <= gain.rms_after_mm


def _worse_at(judged: Improvement) -> WorstPoint | None:
    """Return the worst held-out point where it is far worse than the worst one was without the findings.

    A mean that gets better hides it: a shape that fits where readings are may do anything in between.
    """
    largest_before_mm = float(np.linalg.norm(judged.errors.before_mm, axis=1).max())
    worst = judged.errors.worst
    limit_mm = max(_FAR_WORSE * largest_before_mm, largest_before_mm + 5.0 * judged.noise_mm)
    return worst if worst.after_mm > limit_mm else None


def _with_doubts(tested: SelectionTests) -> Remainder:
    """Add the families that tell the story of a finding better than its name."""
    selected, left = tested.selected, tested.left
    together: dict[Cause, tuple[Candidate, ...]] = {}
    for subject, group in tested.groups:
        cause = Cause(group[0].effect, subject)
        # Waves of one joint are grouped by order; a curve over the angle competes with all of them.
        together[cause] = (*together.get(cause, ()), *group)
    better = tuple(
        one for group in together.values() for one in better_families(selected, group, tested.families)
    )
    return left.also(better)


def _with_shared(start: Start, left: Remainder) -> Remainder:
    """Add what bad readings share. No description holds it: they have no weight in it."""
    shared = shared_properties(start.scene, left.tails.bad)
    if shared is None:
        return left
    return left.also([Relation(shared.on.variable, shared.p_value, shared.on.kind, shared.on.joint, None)])


def _told(answer: _Answer, withdrawn: tuple[Text, ...], without: tuple[str, ...]) -> Diagnosis:
    """Return the diagnosis in the terms of the domain."""
    start, tested = answer.start, answer.tested
    selected, judged, left = tested.selected, answer.judged, tested.left
    whole = None if left.contradicted else answer.whole
    readings = readings_found(start, selected, left, judged)
    found = (*_findings(answer), *(one for one in readings if one.effect not in without))
    findings, small = split_by_size(found)
    remaining = Remaining(
        structure=left.structure,
        depends_on=tuple(
            Dependence(one.variable, one.p_value, remaining_curve(selected, start.scene, one))
            for one in left.depends
        ),
        sentence=remaining_sentence(left, full=selected.full),
        worse_at=left.worse_at,
        described=whole.beside(selected) if whole else (),
        described_gain=judged.described if whole else None,
    )
    verdict = _verdict(bool(findings), left.structure)
    before = statistics(judged.errors.before_mm, judged.noise_mm)
    after = statistics(judged.errors.after_mm, judged.noise_mm)
    nominal = nominal_fit(start.problem, start.fit)
    share = None if left.contradicted or not tested.groups else judged.named_share
    # The small ones too: a cause that has a finding is not reported as "not found".
    named = frozenset(Cause(one.effect, one.subject) for one in found)
    return Diagnosis(
        robot=start.campaign.robot.name,
        verdict=verdict,
        message=first_line(verdict, findings, before, after, remaining, share),
        start_effects=start.effects,
        findings=findings,
        quantity=start.problem.quantity,
        before=before,
        after=after,
        held_out="validation" if judged.source == "validation" else "cross_validation",
        remaining=remaining,
        next_measurements=next_measurements(start, selected, tested.groups, findings, left),
        ruled_out=ruled_out(start.scene, selected, named, without),
        withdrawn=withdrawn,
        noise=noise_of(left),
        errors=judged.errors,
        model=_model(answer, nominal),
        small=small,
        named_share=share,
        nominal=statistics(nominal_errors(start.campaign, nominal), judged.noise_mm),
    )


def _verdict(found: bool, structure: bool) -> Verdict:
    """Return the verdict by whether something was found, and whether something is left."""
    if found:
        return Verdict.PARTLY_EXPLAINED if structure else Verdict.EXPLAINED
    return Verdict.UNEXPLAINED if structure else Verdict.CONSISTENT


def _findings(answer: _Answer) -> tuple[Finding, ...]:
    """Return the findings, those that explain most first."""
    structured = answer.tested.left.structure
    scales = [
        weigh_alternatives(answer.tested.selected, group, structure_left=structured)
        for _, group in answer.tested.groups
    ]
    # Where all findings explain 0, their shares are 0 instead of a division by zero.
    total = sum(scale.explained for scale in scales) or 1.0
    found = [_finding(answer, index, scale, scale.explained / total) for index, scale in enumerate(scales)]
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _finding(answer: _Answer, index: int, scale: RivalComparison, share: float) -> Finding:
    """Return one finding with everything that is said of it.

    It is certain where its gain on held-out readings is above 0 with 97.5 %, nothing is left that nothing
    explains, there is no rival, physics allows it, and no fixed nest contradicts it.
    """
    subject, group = answer.tested.groups[index]
    gain = answer.judged.gains[index]
    shown = description_of(answer.tested.selected, answer.scene, subject, group)
    cell = signature_of(group[0]._replace(subject=subject))
    # Beside structure that nothing explains, no name is sure: the true cause may be in no library.
    helps = gain.interval_95_mm[0] > 0.0 and not answer.tested.left.structure
    against = fixed_nests_contradict(answer.tested.selected.fit, cell)
    sure = helps and not scale.rivals and not shown.impossible and not against
    instead = instrument_suspects(answer.tested.selected, cell) if against else ()
    curve = finding_curve(answer.tested.selected, answer.start.scene, group)
    return Finding(
        effect=group[0].effect,
        subject=shown.subject,
        amplitude=shown.amplitude,
        unit=shown.unit,
        amplitude_standard_uncertainty=shown.standard_uncertainty,
        p_value=scale.p_value,
        confidence=Confidence.CERTAIN if sure else Confidence.LIKELY,
        details=with_known_orders(answer.tested.selected, group, shown.details, answer.scene),
        sentence=together(_sentence(shown), message("causes.contradicted_by_nests") if against else ""),
        confusable_with=tuple(dict.fromkeys((*scale.rivals, *instead))),
        gain=gain,
        parameters=names_of(group),
        share=share,
        curve=curve_with_unseen(curve, answer.unseen, group),
        where=cell.where,
        over=cell.over,
        shape=cell.shape,
        worth=worth_of(answer.tested.selected, names_of(group)),
        spectrum=finding_spectrum(answer.tested.selected, group),
    )


def _sentence(shown: Description) -> Text:
    """Return what is said of a finding; beyond physical limits also that it cannot be what it says."""
    if shown.limits is None or not shown.impossible:
        return shown.sentence
    return message("causes.impossible", sentence=shown.sentence, why=shown.limits.why)


def _model(answer: _Answer, nominal: RobustFit) -> Model:
    """Return the extended model, fitted without what only the diagnosis needed."""
    start, full = answer.start, answer.end
    structure = full.structure.without(_only_of_diagnosis(start.campaign))
    blocks = tuple(block for block in full.blocks if block.table != "reference")
    if _acts_on_instrument(structure.effects):
        # Without the fixed nests, nothing would tell a drift of the instrument from one of the base.
        structure, blocks = full.structure.without((CERTIFICATE,)), full.blocks
    values = np.array([full.values[full.structure.index_of(name)] for name in structure.names])
    solution = refit(structure, blocks, values)
    plain = RobustFit(structure, blocks, solution, full.gross[: len(blocks)], full.chi2_per_dof)
    honest = with_open_shapes(plain, answer.found)
    fits = Fits(start.campaign, honest, nominal, propagate_certificates(start.campaign, honest).total)
    short = shortfall(honest, start.problem.setting)
    # Lengths have no functions beside them. Of positions, folds that choose anew state two to three times too
    # much (decision 0044).
    lacking_mm = _folds_show_mm(answer) if short is None else typical_mm(short, honest)
    draft = model_of(fits, discrepancy_mm=lacking_mm, program_version=__version__)
    return replace(draft, shortfall=short)


def _only_of_diagnosis(campaign: Campaign) -> tuple[str, ...]:
    """Return what no model keeps; the artefact of poses is off in every one, and stays out of the arm."""
    if campaign.tool_rotation_uncertainty_rad is None:
        return NUISANCE
    return tuple(name for name in NUISANCE if name != CERTIFICATE)


def _acts_on_instrument(effects: tuple[str, ...]) -> bool:
    """Whether an effect moves the instrument, whose frame only fixed nests hold."""
    return any(map(of_instrument, effects))


def _folds_show_mm(answer: _Answer) -> float:
    """Return what the usual held-out residuals show per axis beyond the readings' noise [mm]."""
    squared = (answer.folds.errors.after_mm**2).mean(axis=1)
    # Without outliers: they have no weight in the fit either.
    usual = squared <= USUAL * float(np.median(squared))
    noise = answer.start.problem.blocks[0].stated_sigma()
    return float(np.sqrt(max(float(squared[usual].mean()) - noise**2, 0.0)))


def unanswerable(campaign: Campaign, effects: tuple[str, ...], sentence: Text) -> Diagnosis:
    """Return what is said where the present model cannot even be fitted.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str
        As requested; empty for the usual ones.
    sentence : Text
        Why.

    Returns
    -------
    Diagnosis
        Without findings, figures or model; the verdict is `unexplained`.
    """
    readings = campaign.readings
    return Diagnosis(
        robot=campaign.robot.name,
        verdict=Verdict.UNEXPLAINED,
        message=sentence,
        start_effects=effects,
        findings=(),
        quantity="length" if readings is None else readings.quantity,
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
