"""What stands: findings that help configurations left out are kept, the others withdrawn, and it is said why.

All of it rests on cross-validation within the calibration. Validation readings take no part.
"""

from dataclasses import dataclass

from truepose.diagnosis.circumstances import scene_of
from truepose.diagnosis.doubt.doubts import owed_to_the_rest
from truepose.diagnosis.evidence.held_out import CrossValidation, Improvement
from truepose.diagnosis.evidence.remaining import Prepared, prepared_families
from truepose.diagnosis.evidence.sensitivities import shown_of
from truepose.diagnosis.evidence.structure_left import Left, left_by
from truepose.diagnosis.screening.groups import Group, grouped
from truepose.diagnosis.screening.selection import Propose, Selected, reselected
from truepose.diagnosis.start import Start
from truepose.domain.results.causes import Cause
from truepose.domain.results.diagnosis import Gain
from truepose.domain.sentences import Sentence, Text, said

# Of what is wrong: findings that explain less, beside what nothing explains, are not claimed.
_SMALL_PART = 0.2
# Folds of five that must choose it too (stability selection: N. Meinshausen, P. Buehlmann, J. Royal
# Statistical Society B 72(4), 2010, 417-473).
_STEADY = 2


@dataclass(frozen=True, slots=True)
class Tested:
    """A selection, with what configurations left out and its own residuals say of it."""

    selected: Selected
    groups: tuple[Group, ...]
    judged: Improvement  # by cross-validation
    families: tuple[Prepared, ...]
    left: Left


def standing(
    start: Start, selected: Selected, judging: CrossValidation, propose: Propose, without: tuple[str, ...]
) -> tuple[Tested, tuple[Text, ...]]:
    """Withdraw what does not help or cannot be; return what stands, and a sentence for each that does not."""
    withdrawn: tuple[Text, ...] = ()
    refuted: frozenset[Cause] = frozenset()
    tested = _tested(start, selected, judging, without, refuted)
    while useless := _to_withdraw(start, tested):
        groups = tested.groups
        withdrawn += tuple(_withdrawal(start, tested, index) for index in useless)
        refuted |= {Cause(pick.effect, pick.subject) for index in useless for pick in groups[index][1]}
        kept = tuple(pick for k, (_, group) in enumerate(groups) if k not in useless for pick in group)
        selected = reselected(start.fit, tested.selected, kept, propose)
        tested = _tested(start, selected, judging, without, refuted)
    return tested, withdrawn


def _tested(
    start: Start,
    selected: Selected,
    judging: CrossValidation,
    without: tuple[str, ...],
    refuted: frozenset[Cause],
) -> Tested:
    groups = grouped(selected.picks)
    judged = judging.of(selected, tuple(group for _, group in groups))
    families = prepared_families(selected.fit, start.scene)
    return Tested(selected, groups, judged, families, left_by(start, selected, families, without, refuted))


def _useless(
    selected: Selected, groups: tuple[Group, ...], judged: Improvement, left: Left
) -> tuple[int, ...]:
    """Return the findings to withdraw: all where they spoil what is left out, else single ones.

    The choice without a fold rests on fewer readings and may miss what all of them show: only where it does
    harm beyond chance is it refuted. Where it does not help, a finding must be chosen by some folds too: what
    single readings made is not. Single findings must help as they were found. While something is left that
    nothing explains, a finding may owe its place to it: then it is tested again beside that, and all of them
    together must explain a fair part of what is wrong.
    """
    if not groups:
        return ()
    together = judged.together
    spoilt = together.interval_95_mm[1] < 0.0
    if spoilt or (left.structure and _explains_little(together, judged)):
        return tuple(range(len(groups)))
    unsteady = together.rms_before_mm <= together.rms_after_mm
    owed = owed_to_the_rest(selected, [group for _, group in groups], left)
    return tuple(
        index
        for index, gain in enumerate(judged.gains)
        if gain.rms_before_mm <= gain.rms_after_mm
        or (owed[index] and _explains_little(gain, judged))
        or (unsteady and judged.seen_in[index] < _STEADY)
    )


def _to_withdraw(start: Start, tested: Tested) -> tuple[int, ...]:
    """Return the findings that are not kept: those that do not help, and those that physics forbids."""
    useless = _useless(tested.selected, tested.groups, tested.judged, tested.left)
    return useless or tuple(k for k in range(len(tested.groups)) if _forbidden(start, tested, k) != "")


def _forbidden(start: Start, tested: Tested, index: int) -> Text:
    """Return why physics does not let a finding be kept, "" where it does."""
    shown = shown_of(tested.selected, scene_of(start.problem, tested.selected.fit), *tested.groups[index])
    return shown.limits.why if shown.limits and shown.limits.withdrawn and shown.impossible else ""


def _explains_little(gain: Gain, judged: Improvement) -> bool:
    """Whether it is a small part of what is wrong on unseen points that a gain takes away."""
    wrong = gain.rms_before_mm**2 - judged.noise_mm**2
    return gain.rms_before_mm**2 - gain.rms_after_mm**2 < _SMALL_PART * wrong


def _withdrawal(start: Start, tested: Tested, index: int) -> Sentence:
    (subject, picks), gain = tested.groups[index], tested.judged.gains[index]
    why = _forbidden(start, tested, index)
    if why != "":
        return said("withdrawn.forbidden", effect=picks[0].effect, subject=subject, why=why)
    return said(
        "withdrawn.no_help",
        effect=picks[0].effect,
        subject=subject,
        before_mm=gain.rms_before_mm,
        after_mm=gain.rms_after_mm,
    )
