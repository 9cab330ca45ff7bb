"""Doubts: would a finding still be named beside what nothing explains, and is its shape the right one?

*Beside.* Residuals that depend smoothly on something are not independent: a cause that varies along with it
may owe its place to it. Each finding is tested again with the families that are left fitted as random effects.

*Shape.* Each finding is compared with every smooth family in its own place. Where a family, which assumes
nothing but smoothness, is clearly the better story, the name is that of the nearest known cause and no more.
"""

import numpy as np

from service.diagnosis.footing import footing_beside
from service.diagnosis.families import Family
from service.diagnosis.left import Depends, Left
from service.diagnosis.remaining import as_random_effect
from service.diagnosis.screening import chance_beside
from service.diagnosis.selection import LEVEL, Selected
from service.domain.arrays import FloatArray
from service.effects.causes import Candidate

_CLEARLY = 4.0  # in BIC
_SMALLEST = 1e-9


def owed_to_the_rest(selected: Selected, group: tuple[Candidate, ...], left: Left) -> bool:
    """Whether a finding is no longer beyond chance beside the structure that is left."""
    families = [one.columns for one in left.depends if one.columns is not None]
    if not families:
        return False
    names = tuple(name for pick in group for name in pick.names)
    view = selected.pool.view()
    sizes = [as_random_effect(columns, view.footing).width for columns in families]
    seen = [(columns, size) for columns, size in zip(families, sizes, strict=True) if size > _SMALLEST]
    if not seen:
        return False
    columns = np.concatenate([columns for columns, _ in seen])
    widths = np.concatenate([np.full(len(columns), size) for columns, size in seen])
    footing = footing_beside(selected.fit, names, columns, widths)
    rows, believed = _rows_of(selected, group)
    return chance_beside(rows, believed, footing, len(selected.pool.all)) > LEVEL


def _rows_of(selected: Selected, group: tuple[Candidate, ...]) -> tuple[FloatArray, FloatArray]:
    pool = selected.pool
    rows = np.concatenate([pool.rows(pool.all.index(pick)) for pick in group])
    return rows, np.array([spec.prior_width for pick in group for spec in pick.specs])


def better_families(
    selected: Selected, group: tuple[Candidate, ...], families: tuple[tuple[Family, FloatArray], ...]
) -> tuple[Depends, ...]:
    """Return the smooth family that tells a finding's story clearly better than its name, if there is one."""
    names = tuple(name for pick in group for name in pick.names)
    view = selected.pool.view(without=names)
    named = _score(selected, group, names)
    scored = [
        (as_random_effect(columns, view.footing).score, family, columns) for family, columns in families
    ]
    best = max(scored, key=lambda one: one[0], default=None)
    if best is None or best[0] < named + _CLEARLY:
        return ()
    _, family, columns = best
    return (Depends(family.variable, LEVEL, family.kind, family.joint, family, columns=columns),)


def _score(selected: Selected, group: tuple[Candidate, ...], names: tuple[str, ...]) -> float:
    """Gain in BIC of a whole group over the model without it, its search included."""
    footing = selected.pool.view(without=names).footing
    rows, _ = _rows_of(selected, group)
    new = footing.directions(rows)
    after = footing.extended(new)
    variants = [
        sum((other.effect, other.subject) == (pick.effect, pick.subject) for other in selected.pool.all)
        for pick in group
    ]
    counted = max(footing.observations / footing.alike, 2.0)
    gain = (
        footing.degrees / footing.alike * np.log(footing.residual_square / max(after.residual_square, 1e-300))
    )
    return float(gain - new.shape[1] * np.log(counted) - 2.0 * np.log(variants).sum())
