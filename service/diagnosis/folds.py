"""Cross-validation by configuration, all folds from one linearisation.

Parameters are fitted to the other readings to first order, and the held-out ones keep what these predict.
Without each fold the choice is made anew from the start (nested), or a model is taken as it was found and
only its parameters are fitted anew.

References
----------
M. Stone, J. Royal Statistical Society B 36(2), 1974, 111-147 (choice within cross-validation).
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from service.diagnosis.columns import candidate_motions
from service.diagnosis.evidence import described
from service.diagnosis.normal import Normal, normal_of
from service.diagnosis.pool import Pool
from service.diagnosis.selection import chosen
from service.domain.arrays import BoolArray, FloatArray, IntArray
from service.identification.reference import ReferenceBlock
from service.identification.robust import RobustFit
from service.identification.rows import sites

_FOLDS = 5  # four fifths of the configurations choose: nearly as well as all


class Errors(NamedTuple):
    """Errors on configurations held out, (n, d) each: of a model and of what it is compared with."""

    before: FloatArray
    after: FloatArray


class Nested(NamedTuple):
    """Errors on configurations held out, (n, d) each."""

    start: FloatArray
    chosen: FloatArray  # of what is chosen without them
    described: FloatArray  # of every cell that the data ask for without them


def partition(fit: RobustFit, *, in_time: bool) -> tuple[IntArray, ...]:
    """Part the configurations of the first block into folds.

    At random; in time, so that what runs in it must be foretold and cannot be filled in.
    """
    site, time_s = _sites(fit), fit.blocks[0].targets.stops.time_s
    unique = np.unique(site)
    if not in_time or time_s is None:
        return tuple(np.array_split(np.random.default_rng(0).permutation(unique), _FOLDS))
    known = np.nan_to_num(time_s, nan=-np.inf)
    begun = [float(known[site == one].min()) for one in unique.tolist()]
    return tuple(np.array_split(unique[np.argsort(begun, kind="stable")], _FOLDS))


def nested(first: Pool, parts: Sequence[IntArray]) -> Nested:
    """Return the errors of the start, and of what is chosen and described without each part."""
    result = first.fit.results[0]
    errors = Nested(*(np.zeros_like(result.residual) for _ in range(3)))
    for held, out in _held(first.fit, parts):
        start = first.of_rows(_others(first.fit, held))
        choice = chosen(start)
        whole = described(choice.pool, choice.picks)
        for into, picks, normal in (
            (errors.start, (), start.normal),
            (errors.chosen, choice.picks, choice.pool.normal),
            (errors.described, whole.candidates, whole.fitted(start)),
        ):
            motion = np.concatenate([result.jacobian, *candidate_motions(first.fit, picks)])
            into[out] = _left(result.residual[out], motion[:, out], normal)
    return errors


def as_found(fit: RobustFit, parts: Sequence[IntArray], without: tuple[str, ...]) -> Errors:
    """Return the errors of a fitted model without some parameters, and with them."""
    result = fit.results[0]
    before, after = np.zeros_like(result.residual), np.zeros_like(result.residual)
    for held, out in _held(fit, parts):
        normal = normal_of(fit, _others(fit, held))
        before[out] = _left(result.residual[out], result.jacobian[:, out], normal, without)
        after[out] = _left(result.residual[out], result.jacobian[:, out], normal)
    return Errors(before, after)


def _held(fit: RobustFit, parts: Sequence[IntArray]) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the configurations of each part, and their readings in the first block."""
    for held in parts:
        out = np.flatnonzero(np.isin(_sites(fit), held))
        if out.size:
            yield held, out


def _left(
    residual: FloatArray, motion: FloatArray, normal: Normal, without: tuple[str, ...] = ()
) -> FloatArray:
    """Return residuals (o, d) once the parameters took their step, those of motion (P, o, d)."""
    past = normal.past(without)
    step = np.where(past.kept, 0.0, -normal.values)
    step[past.kept] = past.step()
    return np.asarray(residual - np.tensordot(step, motion, 1))


def _sites(fit: RobustFit) -> IntArray:
    return sites(fit.blocks[0].targets.stops)


def _others(fit: RobustFit, held: IntArray) -> BoolArray:
    """Return the stacked observations that are not of the configurations held out, shape (m,)."""
    kept = []
    for block, result in zip(fit.blocks, fit.results, strict=True):
        of_arm = not isinstance(block, ReferenceBlock)
        out = np.isin(sites(block.targets.stops), held) & of_arm
        kept.append(np.repeat(~out, result.residual.shape[1]))
    return np.concatenate(kept)
