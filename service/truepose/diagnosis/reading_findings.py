"""Findings about readings instead of the robot: labels of nests that were swapped, single bad readings.

They have no parameters in the model: a swap was put right before the fit, and a bad reading has no weight in
it. The gain is against a fit that takes every label, or every reading, as it was written.
"""

import itertools
from dataclasses import replace

import numpy as np

from truepose.diagnosis.baseline_fit import Start
from truepose.diagnosis.evidence.held_out_errors import Improvement, gain_of, validation_block
from truepose.diagnosis.evidence.residual_structure import Remainder
from truepose.diagnosis.reading_faults import shared_properties
from truepose.diagnosis.screening.selection import Selection
from truepose.domain.arrays import BoolArray
from truepose.domain.campaign import sites
from truepose.domain.diagnosis import Cause, Confidence, Finding, Gain
from truepose.effects.causes import Candidate, Description, FittedCause
from truepose.effects.readings.label_swap import NAME as LABEL_SWAP
from truepose.effects.readings.label_swap import pair_subject
from truepose.effects.readings.outliers import NAME as OUTLIERS
from truepose.effects.registry import CAUSES
from truepose.effects.signatures import signature_of
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.fit.robust import fit as refit
from truepose.identification.observations.blocks import BlockResult, ObservationBlock
from truepose.identification.observations.poses import position_block
from truepose.messages.message import together

_FAR_MM = 10.0  # further than a bad reading goes: another nest or another row was read


def readings_found(
    start: Start, selected: Selection, left: Remainder, judged: Improvement
) -> tuple[Finding, ...]:
    """Return what is wrong with readings.

    Parameters
    ----------
    start : Start
    selected : Selection
    left : Remainder
        Whose tails say which readings are bad.
    judged : Improvement

    Returns
    -------
    tuple of Finding
        Swapped pairs of nests first, then bad readings, all of them as one finding.
    """
    return (*_swaps(start, selected), *_bad(start, selected, left, judged))


def _swaps(start: Start, selected: Selection) -> tuple[Finding, ...]:
    """Return a finding for each pair of nests whose labels were swapped."""
    written, right = start.written.calibration, start.campaign.calibration
    if written is None or right is None or written is right:
        return ()
    changed = written.nest != right.nest
    pairs = {
        (int(min(one)), int(max(one)))
        for one in zip(written.nest[changed].tolist(), right.nest[changed].tolist(), strict=True)
    }
    fit = selected.fit
    block = fit.blocks[0]
    as_written = replace(block, targets=replace(block.targets, nest=written.nest))
    found = []
    for first, second in sorted(pairs):
        of_pair = np.isin(written.nest, (first, second)) & np.isin(right.nest, (first, second))
        swapped = int((changed & of_pair).sum())
        shown = _shown(LABEL_SWAP, pair_subject(first, second), swapped, int(of_pair.sum()), start)
        chance = _chance(as_written, as_written.result(fit.structure, fit.values, None), changed & of_pair)
        found.append(_finding(LABEL_SWAP, shown, chance, _swap_gain(start, selected)))
    return tuple(found)


def _swap_gain(start: Start, selected: Selection) -> Gain | None:
    """Return the gain on validation readings with their labels put right; None where these were right."""
    written, right = start.written.validation, start.campaign.validation
    if written is None or right is None or np.array_equal(written.nest, right.nest):
        return None
    before = position_block(written, start.campaign.scatter_mm)
    after = position_block(right, start.campaign.scatter_mm)
    structure, values = selected.fit.structure, selected.fit.values
    return gain_of(
        before.result(structure, values, None).residual,
        after.result(structure, values, None).residual,
        sites(right.stops),
    )


def _bad(start: Start, selected: Selection, left: Remainder, judged: Improvement) -> tuple[Finding, ...]:
    """Return the bad readings as one finding, in doubt where they are far off or something is left."""
    bad = left.tails.bad
    if not bad.any():
        return ()
    fit = selected.fit
    shown = _shown(OUTLIERS, "readings", int(bad.sum()), len(bad), start)
    chance = _chance(fit.blocks[0], fit.results[0], bad)
    finding = _finding(OUTLIERS, shown, chance, _bad_gain(start, selected, judged))
    far = float(np.linalg.norm(fit.results[0].residual[bad], axis=1).max()) >= _FAR_MM
    if not (far or left.structure):
        return (finding,)
    swapped = tuple(Cause(LABEL_SWAP, subject) for subject in _pairs(start)) if far else ()
    shared = shared_properties(start.scene, bad)
    sentence = together(finding.sentence, shared.sentence) if shared else finding.sentence
    # Far readings may be of another nest; and beside something that is left, they may be part of it.
    doubted = replace(finding, sentence=sentence, confidence=Confidence.LIKELY, confusable_with=swapped)
    return (doubted,)


def _pairs(start: Start) -> tuple[str, ...]:
    """Return the pairs of nests that follow each other in number."""
    nests = np.unique(start.scene.nest).tolist()
    return tuple(pair_subject(first, second) for first, second in itertools.pairwise(nests))


def _chance(block: ObservationBlock, result: BlockResult, wrong: BoolArray) -> float:
    """Chance, over all readings, that noise alone gives one as far out as the nearest of the wrong ones."""
    nearest = float(block.squared(result)[wrong].min())
    return min(1.0, len(wrong) * chi2_exceeded(nearest, block.components))


def _bad_gain(start: Start, selected: Selection, judged: Improvement) -> Gain | None:
    """Gain on validation readings over a fit that takes every reading as good; None without them."""
    full = selected.fit
    block = validation_block(start.campaign, full.structure)
    if block is None:
        return None
    trusting = tuple(
        # A block whose readings state no uncertainty keeps its discrepancy: with neither it could not be
        # weighed.
        block.weighted(np.ones(len(block.weights)), 0.0 if block.stated_sigma() > 0.0 else block.discrepancy)
        for block in full.blocks
    )
    plain = refit(full.structure, trusting, full.values)
    before = block.result(full.structure, plain.values, None).residual
    return gain_of(before, judged.errors.after_mm, judged.site)


def _shown(effect: str, subject: str, number: int, readings: int, start: Start) -> Description:
    """Return a fault in its cause's words: a share of readings with the standard uncertainty of a share.

    u^2 = p (1 - p) / n, and at least 1 / n^2: of all or none of n readings the share is not known exactly.
    """
    share = number / max(readings, 1)
    uncertainty = float(np.sqrt(max(share * (1.0 - share), 1.0 / max(readings, 1)) / max(readings, 1)))
    fitted = FittedCause((), np.array([share]), np.array([[uncertainty**2]]))
    return CAUSES[effect].describe(subject, fitted, start.scene)


def _finding(effect: str, shown: Description, p_value: float, gain: Gain | None) -> Finding:
    """Return a finding that is certain where its gain is above 0 with 97.5 %."""
    cell = signature_of(Candidate(effect, shown.subject, ()))
    sure = gain is not None and gain.interval_95_mm[0] > 0.0
    return Finding(
        effect=effect,
        subject=shown.subject,
        amplitude=shown.amplitude,
        unit=shown.unit,
        amplitude_standard_uncertainty=shown.standard_uncertainty,
        p_value=p_value,
        confidence=Confidence.CERTAIN if sure else Confidence.LIKELY,
        details=shown.details,
        sentence=shown.sentence,
        confusable_with=(),
        gain=gain,
        parameters=(),
        share=0.0,
        where=cell.where,
        over=cell.over,
        shape=cell.shape,
    )
