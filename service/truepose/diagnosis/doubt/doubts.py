"""Doubts about findings: do they owe their place to what nothing explains, and is their shape right.

*Beside.* Residuals that depend smoothly on something are not independent: a cause that varies along with
it may owe its place to it. Each finding is tested again with the families that are left fitted as random
effects.

*Shape.* Each finding is compared with every smooth family in its own place. Where a family, which assumes
nothing but smoothness, is clearly the better story, the name is that of the nearest known cause and no more.
"""

from collections.abc import Sequence

import numpy as np

from truepose.diagnosis.evidence.remaining import Prepared, as_random_effect
from truepose.diagnosis.evidence.structure_left import Depends, Left
from truepose.diagnosis.screening.explained import chance_beside
from truepose.diagnosis.screening.groups import names_of
from truepose.diagnosis.screening.normal_equations import Normal, Products, Projection, products_of
from truepose.diagnosis.screening.selection import LEVEL, Selected
from truepose.domain.arrays import FloatArray
from truepose.effects.causes import Candidate
from truepose.effects.cells import cell_of, words_of

_CLEARLY = 4.0  # in BIC
_SMALLEST = 1e-9  # mm: a random effect no wider than this changes nothing


def owed_to_the_rest(
    selected: Selected, groups: Sequence[tuple[Candidate, ...]], left: Left
) -> tuple[bool, ...]:
    """Whether each finding is no longer beyond chance beside the structure that is left."""
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


def _is_chance(selected: Selected, group: tuple[Candidate, ...], effects: FloatArray, beside: Normal) -> bool:
    own = _products_of(selected, group)
    wider = Products(own.columns, np.hstack([own.with_jacobian, own.columns @ effects.T]), own.with_residual)
    believed = np.array([spec.prior_width for pick in group for spec in pick.specs])
    past = beside.past(without=names_of(group))
    return chance_beside(wider, believed, past, len(selected.pool.all)) > LEVEL


def _products_of(selected: Selected, group: tuple[Candidate, ...]) -> Products:
    pool = selected.pool
    return pool.products.rows(pool.rows_of([pool.index_of(pick) for pick in group]))


# Causes that are as free as a family is: it tells the same story, and with fewer words.
_SAME_STORY = {"mounting": ("attachment", "time"), "nest constant": ("nest",), "direction": ("direction",)}


def better_families(
    selected: Selected, group: tuple[Candidate, ...], families: tuple[Prepared, ...]
) -> tuple[Depends, ...]:
    """Return the smooth family that tells a finding's story clearly better than its name, if there is one."""
    past = selected.pool.normal.past(without=names_of(group))
    named = _score(selected, group, past)
    words = words_of(cell_of(group[0]))
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
    return (Depends(family.variable, LEVEL, family.kind, family.joint, family, products=products),)


def _score(selected: Selected, group: tuple[Candidate, ...], past: Projection) -> float:
    """Gain in BIC of a whole group over the model without it, its search included."""
    sums, after = past.sums, selected.pool.normal.past().sums
    variants = [
        sum((other.effect, other.subject) == (pick.effect, pick.subject) for other in selected.pool.all)
        for pick in group
    ]
    counted = max(sums.observations / sums.alike, 2.0)
    gain = sums.degrees / sums.alike * np.log(sums.residual_square / after.residual_square)
    return float(gain - len(names_of(group)) * np.log(counted) - 2.0 * np.log(variants).sum())
