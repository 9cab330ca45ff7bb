r"""Configurations to measure next: within what was measured, and those that tell findings apart.

T-optimality tells a finding from its rivals. Take the finding for true: its effect e is what the data hold. A
rival model (the present parameters without the finding's, and the rival's own, p with derivatives X and prior
widths w) fits e at the measured rows as well as it can, p = A^-1 X^T e with A = X^T X + diag(1/w^2) over
whitened rows. At new rows it is off by d = e' - X' p, and measuring them with covariance V adds

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

from truepose.diagnosis.baseline_fit import Start
from truepose.diagnosis.screening.candidates import Pool
from truepose.diagnosis.screening.normal_equations import products_of
from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Cause
from truepose.effects.causes import Candidate
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import (
    candidate_terms,
    position_jacobian,
    trial_derivatives,
    tried,
)
from truepose.identification.model.evaluation import State, Targets, evaluate, rows_of
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.gravity import moment_regressor

_STEP_DEG = 0.01  # what an operator types, and far less than what a configuration is chosen for
_SLACK = 1e-6  # of a step: a limit of whole hundredths stays inside itself


@dataclass(frozen=True, slots=True)
class Places:
    """c configurations, one nest read in each; everything else as at the last reading.

    Attributes
    ----------
    joints_deg : ndarray, shape (c, J)
        Whole steps of 0.01 deg.
    state : State
        Of the extended model.
    """

    joints_deg: FloatArray
    state: State

    @property
    def torque_n_mm(self) -> FloatArray | None:
        """Torques about the joints, shape (c, J); None where they are unknown."""
        return rows_of(self.state).torque_n_mm


@dataclass(frozen=True, slots=True)
class Ranges:
    """Where each joint may be sent, shape (J,) each."""

    low_deg: FloatArray
    high_deg: FloatArray

    def drawn(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw configurations evenly, shape (count, J) [deg]."""
        spread = self.high_deg - self.low_deg
        return self.low_deg + spread * rng.random((count, len(spread)))

    def rounded(self, joints_deg: FloatArray) -> FloatArray:
        """Round configurations to whole steps inside.

        Parameters
        ----------
        joints_deg : ndarray, shape (c, J)

        Returns
        -------
        ndarray, shape (c, J)
            [deg]; a joint that has no step inside stays in the middle of its range.
        """
        first = np.ceil(self.low_deg / _STEP_DEG - _SLACK)
        last = np.floor(self.high_deg / _STEP_DEG + _SLACK)
        steps = np.clip(np.round(joints_deg / _STEP_DEG), first, np.maximum(first, last))
        still = 0.5 * (self.low_deg + self.high_deg)
        # 0.01 is no binary fraction: rounded again, so that what is typed is what was meant.
        return np.where(first <= last, np.round(steps * _STEP_DEG, 2), still)


def measured_ranges(start: Start) -> Ranges:
    """Return the ranges that were measured, within the limits of the controller."""
    joints_deg = np.rad2deg(start.scene.stops.joints_rad)
    low, high = joints_deg.min(axis=0), joints_deg.max(axis=0)
    limits = joint_limits(start)
    if limits is None:
        return Ranges(low, high)
    low = np.clip(low, limits.low_deg, limits.high_deg)
    return Ranges(low, np.clip(high, low, limits.high_deg))


def joint_limits(start: Start) -> Ranges | None:
    """Return the limits of the controller; None where they are unknown."""
    limits = start.campaign.robot.joint_limits
    if limits is None:
        return None
    return Ranges(
        np.rad2deg([limit.lower_rad for limit in limits]), np.rad2deg([limit.upper_rad for limit in limits])
    )


def drawn(start: Start, selected: Selection, ranges: Ranges, count: int, rng: np.random.Generator) -> Places:
    """Draw configurations evenly within ranges.

    Parameters
    ----------
    start : Start
    selected : Selection
    ranges : Ranges
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    Places
        Whole steps of 0.01 deg, evaluated with the extended model.
    """
    joints_deg = ranges.rounded(ranges.drawn(count, rng))
    return Places(joints_deg, _evaluated(selected, joints_deg, _in_time(start.scene.stops)))


def _evaluated(selected: Selection, joints_deg: FloatArray, stops: Stops) -> State:
    """Return the extended model at configurations (c, J) [deg], nests in turn, the rest as read last."""
    fit = selected.fit
    joints_rad = np.deg2rad(joints_deg)
    count = len(joints_rad)
    nests = np.unique(fit.blocks[0].targets.nest)
    asked = Stops(
        config=np.arange(count),
        joints_rad=joints_rad,
        # From which side the arm will come is not planned: 0, unknown, adds nothing to either cause.
        direction=None if stops.direction is None else np.zeros_like(joints_rad, dtype=np.int64),
        time_s=_last(stops.time_s, count),
        temperature_c=_last(stops.temperature_c, count),
        attachment=None if stops.attachment is None else np.full(count, stops.attachment[-1]),
        torque_n_mm=_torques(selected, joints_rad, stops),
    )
    return evaluate(fit.structure, fit.values, Targets(asked, nests[np.arange(count) % len(nests)]))


def _in_time(stops: Stops) -> Stops:
    """Return the stops as they were made, those without a time first; as they stand where no times are."""
    if stops.time_s is None:
        return stops
    return stops.taken(np.argsort(np.nan_to_num(stops.time_s, nan=-np.inf), kind="stable"))


def _last(column: FloatArray | None, count: int) -> FloatArray | None:
    """Return the last known value of a column, shape (count,); NaN where none is known."""
    if column is None:
        return None
    known = column[np.isfinite(column)]
    return np.full(count, known[-1] if known.size else np.nan)


def _torques(selected: Selection, joints_rad: FloatArray, stops: Stops) -> FloatArray | None:
    """Return what torque sensors would read: moments of mass and zeros of sensors fitted to what they did."""
    structure = selected.fit.structure
    if not structure.torques_measured or stops.torque_n_mm is None:
        return None
    there, here = (
        forward(nominal_values(structure.robot, joints), structure.base_rotation, structure.base_origin_mm)
        for joints in (joints_rad, stops.joints_rad)
    )
    measured = stops.torque_n_mm.T.reshape(-1)
    known = np.isfinite(measured)
    # Moments about parallel axes are seen together only; of all that give these torques, the smallest are
    # taken.
    moments = np.linalg.lstsq(_loads(here, structure.gravity_m_s2)[known], measured[known], rcond=1e-6)[0]
    return np.asarray((_loads(there, structure.gravity_m_s2) @ moments).reshape(-1, len(joints_rad)).T)


def _loads(chain: Chain, gravity_m_s2: FloatArray) -> FloatArray:
    """Torques per moment of each frame and per zero of each joint's sensor, shape (J n, 3 J)."""
    joints, n, _ = chain.z.shape
    loads = np.zeros((joints, n, 3 * joints))
    for joint in range(joints):
        loads[joint, :, 2 * joints + joint] = 1.0
        for frame in range(joint, joints):
            for component in range(2):
                loads[joint, :, 2 * frame + component] = moment_regressor(
                    chain, joint, frame, component, gravity_m_s2
                )
    # Moments [kg mm] and zeros [N mm] meet on equal terms where a moment is worth its weight.
    loads[:, :, 2 * joints :] *= max(float(np.linalg.norm(gravity_m_s2)), 1.0)
    return loads.reshape(joints * n, -1)


def filling(places: FloatArray, measured: FloatArray, count: int) -> list[int]:
    """Choose places one by one, each farthest from what was measured and chosen before.

    Parameters
    ----------
    places : ndarray, shape (c, k)
        What the dependence is on, e.g. an angle, at each place.
    measured : ndarray, shape (n, k)
    count : int

    Returns
    -------
    list of int
        Indices of places.

    References
    ----------
    M. E. Johnson, L. M. Moore, D. Ylvisaker, J. Statistical Planning and Inference 26, 1990, 131-148
    (maximin distance designs).
    """
    apart = np.full(len(places), np.inf)
    for row in measured:
        apart = np.minimum(apart, np.linalg.norm(places - row, axis=1))
    chosen: list[int] = []
    for _ in range(min(count, len(places))):
        chosen.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return chosen


def moved_alone(start: Start, joint: int, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw configurations with one joint anywhere in its range, the others as measured.

    Parameters
    ----------
    start : Start
    joint : int
        0-based.
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, shape (count, J)
        [deg].
    """
    stops, ranges = start.scene.stops, measured_ranges(start)
    joints_deg = np.rad2deg(stops.joints_rad[rng.integers(len(stops), size=count)])
    joints_deg[:, joint] = ranges.drawn(count, rng)[:, joint]
    return ranges.rounded(joints_deg)


def one_period(start: Start, joint: int, order: float, count: int) -> FloatArray:
    """Return configurations that step one joint through a period, about a measured one.

    Parameters
    ----------
    start : Start
    joint : int
        0-based.
    order : float
        Periods per turn.
    count : int

    Returns
    -------
    ndarray, shape (count, J)
        [deg]; the measured configuration is the one nearest to the middle of the joint's range.
    """
    ranges = measured_ranges(start)
    angles = np.rad2deg(start.scene.stops.joints_rad)
    middle = 0.5 * (ranges.low_deg + ranges.high_deg)[joint]
    joints_deg = np.repeat(angles[[int(np.argmin(np.abs(angles[:, joint] - middle)))]], count, axis=0)
    joints_deg[:, joint] += 360.0 / order * ((np.arange(count) + 0.5) / count - 0.5)
    return ranges.rounded(joints_deg)


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
