"""Sensitivities: how a cause would move each reading, and the model with all that the data ask for.

A reading with residual r [mm] that moves by u [mm] per unit estimates (r . u) / |u|^2 of it on its own, with
a standard uncertainty of sigma / |u|. Readings that hardly feel the unit say nothing of it and are left out,
as are gross ones.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.definite import solved
from truepose.domain.diagnosis import Described, Worth
from truepose.effects.causes import Candidate, Description, Fitted, Scene
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term, motion_port
from truepose.effects.registry import CAUSES
from truepose.effects.signatures import signature_of
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import trial_derivatives, tried
from truepose.identification.model.evaluation import State

_FELT = 0.02  # of what the typical reading feels


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """What the k readings that feel a unit say of it."""

    rows: BoolArray  # (n,) which readings these are
    left: FloatArray  # (k,) of it in their residuals
    fitted: FloatArray  # (k,) of it in the fitted effect
    standard_uncertainty: FloatArray  # (k,)


def seen(
    selected: Selection, unit_mm: FloatArray, effect_mm: FloatArray, known: BoolArray
) -> Sensitivities | None:
    """Return what readings say of a unit; None where too few feel it.

    Parameters
    ----------
    selected : Selected
    unit_mm, effect_mm : ndarray, shape (n, d)
        What the unit and what the fitted effect do to each reading of the first block.
    known : ndarray, shape (n,)
        Readings whose place on the curve is known.
    """
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    size = np.linalg.norm(unit_mm, axis=1)
    counted = known & block.counts & (size > 0.0)
    if not counted.any():
        return None
    rows = counted & (size > _FELT * float(np.median(size[counted])))
    if int(rows.sum()) < 2:
        return None
    unit, squares = unit_mm[rows], size[rows] ** 2
    spread = np.sqrt(block.component_variance() + block.scatter_mm**2)[rows]
    return Sensitivities(
        rows,
        np.einsum("ni,ni->n", result.residual[rows], unit) / squares,
        np.einsum("ni,ni->n", effect_mm[rows], unit) / squares,
        spread / size[rows],
    )


def state_of(selected: Selection) -> State:
    """Return the extended model at the readings of the first block."""
    return selected.fit.results[0].state


def effect_of(selected: Selection, names: Sequence[str]) -> FloatArray:
    """Return what fitted parameters do to each reading [mm], shape (n, d)."""
    rows = [selected.fit.structure.index_of(name) for name in names]
    return np.asarray(np.tensordot(selected.fit.values[rows], selected.fit.results[0].jacobian[rows], 1))


def worth_of(selected: Selection, names: Sequence[str]) -> Worth:
    """Return how far fitted parameters move the tool over the readings of the first block."""
    way_mm = np.linalg.norm(effect_of(selected, names), axis=1)
    own_mm = np.linalg.norm(_own_effect(selected, names), axis=1)
    return Worth(float(way_mm.mean()), float(way_mm.max()), float(np.sqrt((own_mm**2).mean())))


def _own_effect(selected: Selection, names: Sequence[str]) -> FloatArray:
    """Return by how much readings would be missed without fitted parameters [mm], shape (n, d).

    The others follow as a normal posterior's mean does where those are known to be zero.
    """
    rows = [selected.fit.structure.index_of(name) for name in names]
    values, covariance = values_of(selected, names)
    step = selected.fit.solution.covariance[:, rows] @ solved(covariance, values)
    return np.asarray(np.tensordot(step, selected.fit.results[0].jacobian, 1))


def values_of(selected: Selection, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return fitted parameters, shape (k,), and their covariance, shape (k, k)."""
    rows = [selected.fit.structure.index_of(name) for name in names]
    return selected.fit.values[rows], selected.fit.solution.covariance[np.ix_(rows, rows)]


def moved_by(selected: Selection, terms: Sequence[Term], count: int) -> FloatArray:
    """Return what `count` further parameters do to each reading, per unit [mm], shape (count, n, d)."""
    state = state_of(selected)
    specs = tuple(ParameterSpec(f"way_{k}", "1", 0.0, 1.0) for k in range(count))
    derivatives = selected.fit.blocks[0].derivatives(tried(state, specs, tuple(terms)))
    return np.asarray(trial_derivatives(derivatives, state))


def of_joint(selected: Selection, joint: int) -> FloatArray:
    """Return how each reading moves per angle of a joint (0-based) [mm/rad], shape (n, d)."""
    unit: FloatArray = moved_by(selected, [Term(0, Port(PortKind.THETA, joint), 1.0)], 1)[0]
    return unit


def of_body(selected: Selection, body: int) -> FloatArray:
    """Return how each reading moves per shift of a body along its three axes [1], shape (3, n, d)."""
    return moved_by(selected, [Term(axis, motion_port(body, axis), 1.0) for axis in range(3)], 3)


def description_of(
    selected: Selection, scene: Scene, subject: str, picks: Sequence[Candidate]
) -> Description:
    """Return what picks of one cause are in its own words."""
    names = names_of(picks)
    return CAUSES[picks[0].effect].describe(subject, Fitted(names, *values_of(selected, names)), scene)


@dataclass(frozen=True, slots=True)
class CompleteModel:
    """The model with every cell that the data ask for: what is left, described without a name."""

    fit: RobustFit
    cells: tuple[Candidate, ...]

    def beside(self, selected: Selection) -> tuple[Described, ...]:
        """Return what it describes beside the picks, which are told by their findings; largest first."""
        seen = replace(selected, fit=self.fit)
        found = (Described(*place, worth_of(seen, names)) for place, names in self._places(selected))
        return tuple(sorted(found, key=lambda one: -(one.worth.own_mm or 0.0)))

    def _places(self, selected: Selection) -> Iterator[tuple[tuple[str, str], tuple[str, ...]]]:
        picked = set(names_of(selected.picks))
        names: dict[tuple[str, str], tuple[str, ...]] = {}
        for cell in self.cells:
            where, over, _ = signature_of(cell)
            if picked.isdisjoint(cell.names):
                names[where, over] = (*names.get((where, over), ()), *cell.names)
        yield from names.items()
