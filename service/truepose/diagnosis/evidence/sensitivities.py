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
from truepose.domain.diagnosis import Described, EffectSize
from truepose.domain.singular_covariance import solve_singular
from truepose.effects.causes import Candidate, Description, FittedCause, Scene
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term, motion_port
from truepose.effects.registry import CAUSES
from truepose.effects.signatures import signature_of
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import trial_derivatives, tried
from truepose.identification.model.evaluation import State

# A reading that hardly feels the unit divides its residual by next to nothing: it would fill the picture.
_FELT = 0.02  # of what the typical reading feels


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """What the k readings that feel a unit say of it.

    Attributes
    ----------
    rows : ndarray of bool, shape (n,)
        Which readings these are.
    left : ndarray, shape (k,)
        Of the unit in their residuals.
    fitted : ndarray, shape (k,)
        Of the unit in the fitted effect.
    standard_uncertainty : ndarray, shape (k,)
        Of `left`, in units of the unit.
    """

    rows: BoolArray
    left: FloatArray
    fitted: FloatArray
    standard_uncertainty: FloatArray


def seen(
    selected: Selection, unit_mm: FloatArray, effect_mm: FloatArray, known: BoolArray
) -> Sensitivities | None:
    """Return what readings say of a unit.

    Parameters
    ----------
    selected : Selection
    unit_mm, effect_mm : ndarray, shape (n, d)
        What the unit and what the fitted effect do to each reading of the first block [mm].
    known : ndarray of bool, shape (n,)
        Readings whose place on the curve is known.

    Returns
    -------
    Sensitivities or None
        None where fewer than two readings feel it.
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
    """Return the extended model at the readings of the first block.

    Parameters
    ----------
    selected : Selection

    Returns
    -------
    State
        At n readings.
    """
    return selected.fit.results[0].state


def effect_of(selected: Selection, names: Sequence[str]) -> FloatArray:
    """Return what fitted parameters do to each reading, to first order.

    Parameters
    ----------
    selected : Selection
    names : sequence of str
        k parameters of its model.

    Returns
    -------
    ndarray, shape (n, d)
        [mm], d = 1 of lengths.
    """
    rows = [selected.fit.structure.index_of(name) for name in names]
    return np.asarray(np.tensordot(selected.fit.values[rows], selected.fit.results[0].jacobian[rows], 1))


def worth_of(selected: Selection, names: Sequence[str]) -> EffectSize:
    """Return how far fitted parameters move the tool over the readings of the first block.

    Parameters
    ----------
    selected : Selection
    names : sequence of str
        k parameters of its model.

    Returns
    -------
    EffectSize
        Mean and largest shift [mm], and the RMS error without these parameters, all others fitted again.
    """
    way_mm = np.linalg.norm(effect_of(selected, names), axis=1)
    own_mm = np.linalg.norm(_own_effect(selected, names), axis=1)
    return EffectSize(float(way_mm.mean()), float(way_mm.max()), float(np.sqrt((own_mm**2).mean())))


def _own_effect(selected: Selection, names: Sequence[str]) -> FloatArray:
    """Return by how much readings would be missed without fitted parameters [mm], shape (n, d).

    The others follow as a normal posterior's mean does where those are known to be zero: with values v of
    covariance C_vv, all values change by -C_.v C_vv^-1 v.
    """
    rows = [selected.fit.structure.index_of(name) for name in names]
    values, covariance = values_of(selected, names)
    step = selected.fit.solution.covariance[:, rows] @ solve_singular(covariance, values)
    return np.asarray(np.tensordot(step, selected.fit.results[0].jacobian, 1))


def values_of(selected: Selection, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return fitted parameters with their covariance.

    Parameters
    ----------
    selected : Selection
    names : sequence of str
        k parameters of its model.

    Returns
    -------
    values : ndarray, shape (k,)
        Internal units.
    covariance : ndarray, shape (k, k)
        All other parameters being open.
    """
    rows = [selected.fit.structure.index_of(name) for name in names]
    return selected.fit.values[rows], selected.fit.solution.covariance[np.ix_(rows, rows)]


def parameter_effects(selected: Selection, terms: Sequence[Term], count: int) -> FloatArray:
    """Return what further parameters do to each reading, per unit.

    Parameters
    ----------
    selected : Selection
    terms : sequence of Term
        How they act on the ports of the chain, numbered from 0.
    count : int
        How many parameters there are.

    Returns
    -------
    ndarray, shape (count, n, d)
        [mm per unit].
    """
    state = state_of(selected)
    specs = tuple(ParameterSpec(f"way_{k}", "1", 0.0, 1.0) for k in range(count))
    derivatives = selected.fit.blocks[0].derivatives(tried(state, specs, tuple(terms)))
    return np.asarray(trial_derivatives(derivatives, state))


def of_joint(selected: Selection, joint: int) -> FloatArray:
    """Return how each reading moves per angle of a joint.

    Parameters
    ----------
    selected : Selection
    joint : int
        0-based.

    Returns
    -------
    ndarray, shape (n, d)
        [mm/rad].
    """
    unit: FloatArray = parameter_effects(selected, [Term(0, Port(PortKind.THETA, joint), 1.0)], 1)[0]
    return unit


def of_body(selected: Selection, body: int) -> FloatArray:
    """Return how each reading moves per shift of a body along its three axes.

    Parameters
    ----------
    selected : Selection
    body : int
        0 is the base, the number of joints the tool.

    Returns
    -------
    ndarray, shape (3, n, d)
        [1].
    """
    return parameter_effects(selected, [Term(axis, motion_port(body, axis), 1.0) for axis in range(3)], 3)


def description_of(
    selected: Selection, scene: Scene, subject: str, picks: Sequence[Candidate]
) -> Description:
    """Return what picks of one cause are in its own words.

    Parameters
    ----------
    selected : Selection
    scene : Scene
        Of the extended model.
    subject : str
    picks : sequence of Candidate
        Of one cause on that subject, at least one.

    Returns
    -------
    Description
    """
    names = names_of(picks)
    return CAUSES[picks[0].effect].describe(subject, FittedCause(names, *values_of(selected, names)), scene)


@dataclass(frozen=True, slots=True)
class CompleteModel:
    """The model with every cell that the data ask for: what is left, described without a name.

    Attributes
    ----------
    fit : RobustFit
        Of the findings and the cells.
    cells : tuple of Candidate
        Random functions, those of the findings among them.
    """

    fit: RobustFit
    cells: tuple[Candidate, ...]

    def beside(self, selected: Selection) -> tuple[Described, ...]:
        """Return what it describes beside the picks, which have their own findings.

        Parameters
        ----------
        selected : Selection
            The findings.

        Returns
        -------
        tuple of Described
            One a place and variable, largest RMS first.
        """
        seen = replace(selected, fit=self.fit)
        found = (Described(*place, worth_of(seen, names)) for place, names in self._places(selected))
        return tuple(sorted(found, key=lambda one: -(one.worth.own_mm or 0.0)))

    def _places(self, selected: Selection) -> Iterator[tuple[tuple[str, str], tuple[str, ...]]]:
        """Yield each place and variable with the names of its parameters, those of the picks left out."""
        picked = set(names_of(selected.picks))
        names: dict[tuple[str, str], tuple[str, ...]] = {}
        for cell in self.cells:
            where, over, _ = signature_of(cell)
            if picked.isdisjoint(cell.names):
                names[where, over] = (*names.get((where, over), ()), *cell.names)
        yield from names.items()
