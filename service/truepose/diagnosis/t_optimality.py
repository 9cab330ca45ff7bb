r"""T-optimality: configurations to measure next that tell a finding from its rivals.

Take the finding for true: its effect e is what the data hold. A rival model (the present parameters without
the finding's, and the rival's own, p with derivatives X and prior widths w) fits e at the measured rows as
well as it can, p = A^-1 X^T e with A = X^T X + diag(1/w^2) over whitened rows. At new rows it is off by d =
e' - X' p, and measuring them with covariance V adds

    T = d^T (V + X' A^-1 X'^T)^-1 d

to its least sum of squares: what the present parameters would absorb of the difference does not count. T is
the expected chi-square by which the new rows speak against the rival. Configurations are added one by one,
each time the one that adds most over all rivals: sum of ln(1 + T/9), so that none is left behind.

References
----------
A. C. Atkinson, V. V. Fedorov, Biometrika 62(1), 1975, 57-70 (T-optimality, several rivals: ibid. 289-303).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.configurations import Places
from truepose.diagnosis.screening.candidates import Pool
from truepose.diagnosis.screening.normal_equations import products_of
from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause
from truepose.effects.causes import Candidate
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import (
    candidate_terms,
    position_jacobian,
    trial_derivatives,
    tried,
)

CONVINCING = 9.0  # expected chi-square: three standard deviations
_ENOUGH = 25.0  # five: what is beyond buys nothing
_FEWEST, _MOST = 3, 5  # the instrument may not see all of them


@dataclass(frozen=True, slots=True)
class Separation:
    """Configurations to measure, and what they will tell.

    Attributes
    ----------
    rows : tuple of int
        Of the places, in the order in which they were chosen.
    chi_square : ndarray, shape (R,)
        Expected of each rival once they are measured; 0 of one that may be a curve of any shape.
    """

    rows: tuple[int, ...]
    chi_square: FloatArray


@dataclass(frozen=True, slots=True)
class _Duel:
    """A finding against one rival, at c places, in coordinates in which A is the unit matrix.

    Attributes
    ----------
    misfit : ndarray, shape (c, d)
        d = e' - X' p, what the rival misses of the finding's effect [mm].
    columns : ndarray, shape (c, d, q)
        X' A^-1/2 [mm].
    """

    misfit: FloatArray
    columns: FloatArray


def separation(
    selected: Selection,
    group: Sequence[Candidate],
    rivals: Sequence[Cause],
    places: Places,
    repeats: int = 1,
) -> Separation:
    """Choose three to five places at which the rivals would be exposed.

    Parameters
    ----------
    selected : Selection
    group : sequence of Candidate
        Picks of the finding.
    rivals : sequence of Cause
        R of them; each by the way in which it mimics the finding best.
    places : Places
        c >= 5 of them.
    repeats : int
        How often each place is read.

    Returns
    -------
    Separation
    """
    ways = [_ways(selected.pool, rival) for rival in rivals]
    shaped = [number for number, own in enumerate(ways) if own]
    duels = [_duel(selected, group, ways[number], places) for number in shaped]
    variance = reading_variance(selected.fit, repeats)
    reached, rows = np.zeros(len(duels)), list[int]()
    for _ in range(_MOST if duels else 0):
        if len(rows) >= _FEWEST and (reached >= _ENOUGH).all():
            break
        added = np.stack([_added(duel, variance) for duel in duels])
        # The logarithm keeps one rival that is nearly exposed from drawing all configurations to itself.
        worth = np.log1p((reached[:, None] + added) / CONVINCING).sum(axis=0)
        # No place twice: repeats are proposed for all places alike, where single readings do not suffice.
        worth[rows] = -np.inf
        best = int(np.argmax(worth))
        reached = reached + added[:, best]
        rows.append(best)
        duels = [_measured(duel, best, variance) for duel in duels]
    chi_square = np.zeros(len(rivals))
    chi_square[shaped] = reached
    return Separation(tuple(rows), chi_square)


def reading_variance(fit: RobustFit, repeats: int = 1) -> float:
    """Return the variance per axis of a typical reading [mm2].

    Parameters
    ----------
    fit : RobustFit
    repeats : int
        Readings that are averaged. They take the noise down; what the model lacks stays.
    """
    block = fit.blocks[0]
    lacking = block.discrepancy**2
    noise = float(np.median(block.component_variance())) - lacking + block.scatter_mm**2
    return noise / repeats + lacking


def _ways(pool: Pool, rival: Cause) -> list[int]:
    """Return which candidates are ways in which a rival may act."""
    return [
        index
        for index, candidate in enumerate(pool.all)
        # A function of any shape mimics everything, and is refuted nowhere.
        if Cause(candidate.effect, candidate.subject) == rival and not candidate.function
    ]


def _duel(selected: Selection, group: Sequence[Candidate], ways: Sequence[int], places: Places) -> _Duel:
    """Return a finding against the ways in which one rival may act, before anything new is measured."""
    fit, pool, names = selected.fit, selected.pool, names_of(group)
    own = np.isin(fit.structure.names, names)
    effect = fit.values[own] @ fit.solution.final.jacobian[own]
    index = _closest(pool, effect, names, ways)
    best = pool.all[index]
    widths = np.array([spec.prior_width for spec in best.specs])
    past = pool.normal.beside(pool.products.rows(pool.own(index)), widths, best.names).past(names)
    across = np.concatenate([fit.solution.final.jacobian @ effect, pool.rows(index) @ effect])
    fitted = past.parameters(past.coordinates(across[None])[0])

    present = position_jacobian(places.state)
    motion = np.concatenate([present, _columns_of(best, places)])
    misfit = np.tensordot(fit.values[own], present[own], 1) - np.tensordot(fitted, motion[past.kept], 1)
    unit = past.coordinates(motion.reshape(len(motion), -1).T)
    return _Duel(misfit, unit.reshape(*misfit.shape, -1))


def _closest(pool: Pool, effect: FloatArray, names: tuple[str, ...], ways: Sequence[int]) -> int:
    """Return the way that mimics an effect (m,) best, beside the parameters but `names`."""
    past = pool.normal.past(names)
    of_effect = past.absorbed(products_of(pool.fit, effect[None]))[0]

    def explained(index: int) -> float:
        """Return the sum of squares of the effect that a candidate explains."""
        products = pool.products.rows(pool.own(index))
        absorbed = past.absorbed(products)
        towards = products.columns @ effect - absorbed @ of_effect
        gram = pool.grams[index] - absorbed @ absorbed.T
        # Under its prior: a rival must not mimic the finding by an amplitude beyond what is plausible.
        gram += np.diag([spec.prior_width**-2.0 for spec in pool.all[index].specs])
        return float(towards @ np.linalg.lstsq(gram, towards, rcond=None)[0])

    return max(ways, key=explained)


def _columns_of(candidate: Candidate, places: Places) -> FloatArray:
    """Return derivatives of a candidate's parameters at the places, shape (k, c, 3)."""
    terms = candidate_terms(places.state, candidate.effect, candidate.names, 0)
    return trial_derivatives(position_jacobian(tried(places.state, candidate.specs, terms)), places.state)


def _added(duel: _Duel, variance: float) -> FloatArray:
    """Chi-square that each place would add, shape (c,)."""
    return np.asarray(np.einsum("ci,ci->c", duel.misfit, _weighed(duel, variance)))


def _weighed(duel: _Duel, variance: float) -> FloatArray:
    """Return (V + X' A^-1 X'^T)^-1 d at each place, shape (c, d)."""
    inner = duel.columns @ np.swapaxes(duel.columns, 1, 2)
    inner += variance * np.eye(inner.shape[1])
    return np.asarray(np.linalg.solve(inner, duel.misfit[:, :, None])[:, :, 0])


def _measured(duel: _Duel, row: int, variance: float) -> _Duel:
    """Return the duel once a place has been measured: the rival fitted to it too."""
    here = duel.columns[row]  # (d, q)
    covariance = here @ here.T + variance * np.eye(len(here))
    step = here.T @ np.linalg.solve(covariance, duel.misfit[row])
    # A^-1 becomes I - U U^T; its square root I - U (1 - sqrt(1 - s^2)) U^T keeps coordinates of unit matrix.
    axes, sizes, _ = np.linalg.svd(here.T, full_matrices=False)
    shrunk = 1.0 - np.sqrt(variance / (variance + sizes**2))
    columns = duel.columns - ((duel.columns @ axes) * shrunk) @ axes.T
    return _Duel(duel.misfit - duel.columns @ step, columns)
