"""Confidence in findings: whether they help configurations left out, and what speaks against them.

*Beside.* Residuals that depend smoothly on something are not independent: a cause that varies along with it
may owe its place to it. Each finding is tested again (F test, `screening.significance`) with the families
that are left fitted as random effects of their most likely widths.

*Shape.* Each finding is compared with every smooth family in its own place, both by BIC:

    finding  nu ln(R / R_with) - k ln n - 2 ln(variants),    family  2 ln L(width) - 2 ln L(0) - ln n.

Where a family, which assumes nothing but smoothness, is clearly the better story, the name is that of the
nearest known cause and no more.

*Held out.* Findings that help configurations left out are kept, the others withdrawn with the reason. All of
it rests on cross-validation within the calibration. Validation readings take no part.

*Between readings.* Waves are chosen because they fit the angles that were measured. Other orders would fit
them nearly as well and go another way in between. So every order stays in the covariance of the model, with
the value 0 and the size of what was found as its width: where readings are, they hold it; in a gap of the
angles, and beyond them, it is as open as it was (decision 0026).

References
----------
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, section 2.1 (a linear
model in fixed functions with a normal prior of their weights).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.baseline_fit import Start, scene_of
from truepose.diagnosis.evidence.held_out_errors import CrossValidation, Improvement
from truepose.diagnosis.evidence.residual_structure import (
    Prepared,
    Relation,
    Remainder,
    as_random_effect,
    prepared_families,
    residual_dependence,
    score_families,
)
from truepose.diagnosis.evidence.sensitivities import description_of
from truepose.diagnosis.screening.normal_equations import NormalEquations, Products, Projection, products_of
from truepose.diagnosis.screening.selection import (
    LEVEL,
    Group,
    Propose,
    Selection,
    group_by_subject,
    names_of,
    reselect,
)
from truepose.diagnosis.screening.significance import chance_beside
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, Finding, Gain
from truepose.effects.causes import Candidate
from truepose.effects.ports import ParameterSpec, Trait
from truepose.effects.registry import effects_with
from truepose.effects.signatures import signature_of, words_of
from truepose.effects.waves import joint_of_wave, order_of_wave, wave_specs
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.solver import Solution, posterior_covariance
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import linearise_blocks
from truepose.messages.message import Message, Text, message

_CLEARLY = 4.0  # in BIC
_SMALLEST = 1e-9  # mm: a random effect no wider than this changes nothing


def owed_to_the_rest(
    selected: Selection, groups: Sequence[tuple[Candidate, ...]], left: Remainder
) -> tuple[bool, ...]:
    """Return whether each finding is no longer beyond chance beside the structure that is left.

    Parameters
    ----------
    selected : Selection
    groups : sequence of tuple of Candidate
        Picks of each finding.
    left : Remainder
        Of that selection.

    Returns
    -------
    tuple of bool
        One a group; false for all where nothing is left that has a size.
    """
    normal = selected.pool.normal
    families = [one.products for one in left.depends if one.products is not None]
    widths = [as_random_effect(products, normal.past()).width for products in families]
    seen = [(products, width) for products, width in zip(families, widths, strict=True) if width > _SMALLEST]
    if not seen:
        return (False,) * len(groups)
    effects = products_of(selected.fit, np.concatenate([products.columns for products, _ in seen]))
    sizes = np.concatenate([np.full(len(products.columns), width) for products, width in seen])
    beside = normal.beside(effects, sizes, tuple(f"effect {k}" for k in range(len(sizes))))
    return tuple(_is_chance(selected, group, effects.columns, beside) for group in groups)


def _is_chance(
    selected: Selection, group: tuple[Candidate, ...], effects: FloatArray, beside: NormalEquations
) -> bool:
    """Whether a group explains no more than noise, past the model without it and the effects beside it."""
    own = _products_of(selected, group)
    wider = Products(own.columns, np.hstack([own.with_jacobian, own.columns @ effects.T]), own.with_residual)
    believed = np.array([spec.prior_width for pick in group for spec in pick.specs])
    past = beside.past(without=names_of(group))
    return chance_beside(wider, believed, past, len(selected.pool.all)) > LEVEL


def _products_of(selected: Selection, group: tuple[Candidate, ...]) -> Products:
    """Return the products of the columns of a group with the fit."""
    pool = selected.pool
    return pool.products.rows(pool.rows_of([pool.index_of(pick) for pick in group]))


# Causes that are as free as a family is: it tells the same story, and with fewer words.
_SAME_STORY = {"mounting": ("attachment", "time"), "nest constant": ("nest",), "direction": ("direction",)}


def better_families(
    selected: Selection, group: tuple[Candidate, ...], families: tuple[Prepared, ...]
) -> tuple[Relation, ...]:
    """Return the smooth family that explains a finding clearly better than its name does.

    Parameters
    ----------
    selected : Selection
    group : tuple of Candidate
        Picks of the finding.
    families : tuple of (Family, Products)
        Prepared at the selection's fit.

    Returns
    -------
    tuple of Relation
        The best one, with the chance of what it explains in the place of the finding; empty where none is
        better by 4 in BIC.
    """
    # Both are weighed in the finding's own place: past all others, with the finding taken out.
    past = selected.pool.normal.past(without=names_of(group))
    named = _score(selected, group, past)
    words = words_of(signature_of(group[0]))
    same = tuple(kind for word, kinds in _SAME_STORY.items() if word in words for kind in kinds)
    scored = [
        (as_random_effect(products, past).score, family, products)
        for family, products in families
        if family.kind not in same
    ]
    best = max(scored, key=lambda one: one[0], default=None)
    if best is None or best[0] < named + _CLEARLY:
        return ()
    _, family, products = best
    (alone,) = score_families(((family, products),), past)
    chance = min(1.0, len(families) * alone.p_value)
    return (Relation(family.variable, chance, family.kind, family.joint, family, products=products),)


def _score(selected: Selection, group: tuple[Candidate, ...], past: Projection) -> float:
    """Gain in BIC of a whole group over the model without it, its search included."""
    pool = selected.pool
    sums, after = past.sums, pool.normal.past().sums
    tried = pool.tried[[pool.index_of(pick) for pick in group]]
    counted = max(sums.observations / sums.alike, 2.0)
    gain = sums.degrees / sums.alike * np.log(sums.residual_square / after.residual_square)
    return float(gain - len(names_of(group)) * np.log(counted) - 2.0 * np.log(tried).sum())


# Of what is wrong: findings that explain less, beside what nothing explains, are not claimed.
_SMALL_PART = 0.2
# Folds of five that must choose it too (stability selection: N. Meinshausen, P. Buehlmann, J. Royal
# Statistical Society B 72(4), 2010, 417-473).
_STEADY = 2


@dataclass(frozen=True, slots=True)
class SelectionTests:
    """A selection, with what configurations left out and its own residuals say of it.

    Attributes
    ----------
    selected : Selection
    groups : tuple of (str, tuple of Candidate)
        Its picks by subject.
    judged : Improvement
        By cross-validation.
    families : tuple of (Family, Products)
        Prepared at its fit.
    left : Remainder
    """

    selected: Selection
    groups: tuple[Group, ...]
    judged: Improvement
    families: tuple[Prepared, ...]
    left: Remainder


def standing(
    start: Start,
    selected: Selection,
    judging: CrossValidation,
    propose: Propose,
    without: tuple[str, ...],
) -> tuple[SelectionTests, tuple[Text, ...]]:
    """Withdraw findings that do not help or cannot be, until all that remain pass.

    Parameters
    ----------
    start : Start
    selected : Selection
        What was found.
    judging : CrossValidation
        Of the same start.
    propose : callable
        From a fit to every way in which it may still be wrong.
    without : tuple of str
        Causes that are left out of the library.

    Returns
    -------
    tested : SelectionTests
        What remains.
    withdrawn : tuple of Text
        A sentence for each finding that was withdrawn.
    """
    withdrawn: tuple[Text, ...] = ()
    refuted: frozenset[Cause] = frozenset()
    tested = _tested(start, selected, judging, without, refuted)
    while useless := _to_withdraw(start, tested):
        groups = tested.groups
        withdrawn += tuple(_withdrawal(start, tested, index) for index in useless)
        # A refuted cause would otherwise come back as structure: its single waves are in the pool again.
        refuted |= {Cause(pick.effect, pick.subject) for index in useless for pick in groups[index][1]}
        kept = tuple(pick for k, (_, group) in enumerate(groups) if k not in useless for pick in group)
        selected = reselect(start.fit, tested.selected, kept, propose)
        tested = _tested(start, selected, judging, without, refuted)
    return tested, withdrawn


def _tested(
    start: Start,
    selected: Selection,
    judging: CrossValidation,
    without: tuple[str, ...],
    refuted: frozenset[Cause],
) -> SelectionTests:
    """Return a selection with its groups, its judgement by cross-validation, and what it leaves."""
    groups = group_by_subject(selected.picks)
    judged = judging.of(selected, tuple(group for _, group in groups))
    families = prepared_families(selected.fit, start.scene)
    return SelectionTests(
        selected, groups, judged, families, residual_dependence(start, selected, families, without, refuted)
    )


def _useless(
    selected: Selection, groups: tuple[Group, ...], judged: Improvement, left: Remainder
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


def _to_withdraw(start: Start, tested: SelectionTests) -> tuple[int, ...]:
    """Return the findings that are not kept: those that do not help, and those that physics forbids."""
    useless = _useless(tested.selected, tested.groups, tested.judged, tested.left)
    return useless or tuple(k for k in range(len(tested.groups)) if _forbidden(start, tested, k) != "")


def _forbidden(start: Start, tested: SelectionTests, index: int) -> Text:
    """Return why physics does not let a finding be kept, "" where it does."""
    shown = description_of(
        tested.selected, scene_of(start.problem, tested.selected.fit), *tested.groups[index]
    )
    return shown.limits.why if shown.limits and shown.limits.withdrawn and shown.impossible else ""


def _explains_little(gain: Gain, judged: Improvement) -> bool:
    """Whether it is a small part of what is wrong on unseen points that a gain takes away."""
    wrong = gain.rms_before_mm**2 - judged.noise_mm**2
    return gain.rms_before_mm**2 - gain.rms_after_mm**2 < _SMALL_PART * wrong


def _withdrawal(start: Start, tested: SelectionTests, index: int) -> Message:
    """Return the sentence that says why a finding was withdrawn."""
    (subject, picks), gain = tested.groups[index], tested.judged.gains[index]
    why = _forbidden(start, tested, index)
    if why != "":
        return message("withdrawn.forbidden", effect=picks[0].effect, subject=subject, why=why)
    return message(
        "withdrawn.no_help",
        effect=picks[0].effect,
        subject=subject,
        before_mm=gain.rms_before_mm,
        after_mm=gain.rms_after_mm,
    )


_SMALL = 0.02  # of the held-out error


def split_by_size(findings: tuple[Finding, ...]) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings that count as causes, and those that are small.

    Parameters
    ----------
    findings : tuple of Finding
        Largest share first; the leading one always counts.

    Returns
    -------
    tuple of tuple of Finding
        Those that count, and those that take less than 2 % off the held-out error.
    """
    small = tuple(finding for finding in findings[1:] if _is_small(finding))
    return tuple(finding for finding in findings if finding not in small), small


def _is_small(finding: Finding) -> bool:
    """Whether it takes less off the held-out error than anybody would act upon; bad readings stay bad."""
    gain = finding.gain
    if gain is None or not finding.parameters:
        return False
    return gain.rms_after_mm > (1.0 - _SMALL) * gain.rms_before_mm


(_WAVES,) = effects_with(Trait.WAVES)
_ORDERS = range(1, 13)  # a gap of the angles that is narrower than these waves leaves nothing open


def with_open_shapes(fit: RobustFit, found: RobustFit) -> RobustFit:
    """Return a fit whose covariance holds what the readings leave open of the shapes found.

    Measured on simulated robots with three waves on each of three joints, calibrated without 70 deg of joint
    1: errors over predicted uncertainties in that gap were 39 on average, and are 1.2 with the open orders.

    Parameters
    ----------
    fit : RobustFit
        Of a model with waves of some joints; without them it comes back as it is.
    found : RobustFit
        Of the findings alone, as free as their readings are: how large waves are is told by both.

    Returns
    -------
    RobustFit
        The same predictions; parameters of value 0 and a covariance of all of them.
    """
    widths_rad = np.maximum(_widths_rad(fit), _widths_rad(found))
    if not widths_rad.any():
        return fit
    specs = _open_specs(fit, widths_rad)
    structure = _widened(fit.structure, found.structure, widths_rad).extended(_WAVES, specs)
    values = np.concatenate([fit.values, np.zeros(len(specs))])
    # Not fitted again: in a gap, the values of orders that were not found would be those of the prior
    # (decision 0026).
    point = linearise_blocks(structure, fit.blocks, values, None)
    covariance = posterior_covariance(point.jacobian, 1.0 / structure.prior_widths**2)
    solution = Solution(values, covariance, fit.solution.converged, fit.solution.iterations, point)
    return replace(fit, structure=structure, solution=solution)


def _widened(structure: Structure, found: Structure, widths_rad: FloatArray) -> Structure:
    """Return the structure with its own slow waves as open as others of their joint, fast ones as when found.

    The waves of a curve share one width, which is that of all orders: a slow one may be larger.
    """
    free = {spec.name: spec.prior_width for spec in found.specs}

    def opened(spec: ParameterSpec, owner: str) -> ParameterSpec:
        """Return a parameter with its prior opened, where it is a wave."""
        if owner != _WAVES:
            return spec
        slow = order_of_wave(spec.name) in _ORDERS
        width = float(widths_rad[joint_of_wave(spec.name)]) if slow else free.get(spec.name, 0.0)
        return spec._replace(prior_width=max(spec.prior_width, width))

    specs = tuple(opened(spec, owner) for spec, owner in zip(structure.specs, structure.owners, strict=True))
    return replace(structure, specs=specs)


def _open_specs(fit: RobustFit, widths_rad: FloatArray) -> tuple[ParameterSpec, ...]:
    """Return the waves of all orders that the model does not have, as wide as the largest on their joint."""
    known = set(fit.structure.names)
    return tuple(
        spec._replace(prior_width=float(width))
        for joint, width in enumerate(widths_rad)
        if width > 0.0
        for order in _ORDERS
        for spec in wave_specs(joint, float(order))
        if spec.name not in known
    )


def _widths_rad(fit: RobustFit) -> FloatArray:
    """Return the standard deviation of a further wave's sine and cosine on each joint.

    That of the largest one found, with what is not known of it.
    """
    largest = np.zeros(fit.structure.robot.n_joints)
    sizes = np.hypot(fit.values, np.sqrt(np.diag(fit.solution.covariance)))
    for name, owner, size in zip(fit.structure.names, fit.structure.owners, sizes.tolist(), strict=True):
        if owner == _WAVES:
            joint = joint_of_wave(name)
            largest[joint] = max(largest[joint], size)
    return largest
