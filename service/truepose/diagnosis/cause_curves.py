"""Curves of causes: residuals along one variable, with the fitted cause over them and its 95 % band.

The fitted cause is linear in its parameters v with covariance C: its line is w(x) . v, its band
1.96 sqrt(w^T C w). A reading that moves by u per unit of the quantity is drawn at (r . u) / |u|^2 of it, r
its residual without the cause (`evidence.sensitivities`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.evidence.sensitivities import (
    Sensitivities,
    effect_of,
    of_body,
    of_joint,
    parameter_effects,
    seen,
    state_of,
    values_of,
)
from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Curve
from truepose.effects.causes import Candidate, Scene
from truepose.effects.motions import SECONDS_PER_HOUR
from truepose.effects.ports import Rows, Term, Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.effects.signatures import signature_of
from truepose.effects.waves import ONE_PERIOD_FROM, is_whole, order_of_wave
from truepose.identification.distributions import WITHIN_95
from truepose.identification.model.evaluation import rows_of

N_MM_PER_N_M = 1e3
DRAWN = 200  # points of a line


@dataclass(frozen=True, slots=True)
class Axis:
    """A variable at the n readings.

    Attributes
    ----------
    variable : str
        As reported, e.g. "angle of joint 4".
    unit : str
    x : ndarray, shape (n,)
        NaN where it is unknown.
    stepped : bool
        Numbers of things instead of amounts.
    """

    variable: str
    unit: str
    x: FloatArray
    stepped: bool = False

    @property
    def known(self) -> BoolArray:
        """Readings where it is known, shape (n,)."""
        return np.isfinite(self.x)

    def drawn(self, count: int) -> FloatArray:
        """Return evenly spread values over the range, shape (count,); zeros where none is known."""
        known = self.x[self.known]
        if known.size == 0:
            return np.zeros(count)
        return np.linspace(float(known.min()), float(known.max()), count)

    def levels(self) -> FloatArray:
        """Return the values that occur, ascending, shape (l,)."""
        return np.unique(self.x[self.known])


def angle_axis(turn_rad: FloatArray, joint: int, order: float = 1.0) -> Axis:
    """Return the angle of a joint, within one period where waves of that order are fast.

    Parameters
    ----------
    turn_rad : ndarray, shape (n, J)
        Angles of the joints about their own axes.
    joint : int
        0-based.
    order : float
        Periods per turn.

    Returns
    -------
    Axis
        [deg].
    """
    angle_deg = np.rad2deg(turn_rad)
    if order > ONE_PERIOD_FROM:
        variable = f"angle of joint {joint + 1} within one period"
        return Axis(variable, "deg", np.mod(angle_deg, 360.0 / order))
    return Axis(f"angle of joint {joint + 1}", "deg", angle_deg)


def level_axis(variable: str, numbers: FloatArray | IntArray) -> Axis:
    """Return an axis of numbers of nests or mountings, or of directions.

    Parameters
    ----------
    variable : str
    numbers : ndarray, shape (n,)
        0 is unknown, and is left out.

    Returns
    -------
    Axis
    """
    values = numbers.astype(float)
    return Axis(variable, "", np.where(values == 0.0, np.nan, values), stepped=True)


def time_axis(scene: Scene, over: str) -> Axis | None:
    """Return the temperature or the time of the readings.

    Parameters
    ----------
    scene : Scene
    over : str
        "temperature" [degC]; anything else is time [h] since the scene's origin.

    Returns
    -------
    Axis or None
        None where it is unknown.
    """
    stops = scene.stops
    if over == "temperature":
        return None if stops.temperature_c is None else Axis("temperature", "degC", stops.temperature_c)
    if stops.time_s is None:
        return None
    return Axis("time", "h", (stops.time_s - scene.origin_s) / SECONDS_PER_HOUR)


_PER_WAVE = 12  # points of each wave in it
_PERIODIC = frozenset({"wave", "curve"})


def _curve(
    axis: Axis,
    quantity: tuple[str, str],
    told: Sensitivities,
    line_x: FloatArray,
    line: tuple[FloatArray, FloatArray],
) -> Curve:
    """Return a curve from what readings say of the quantity, and the line with its band."""
    return Curve(
        variable=axis.variable,
        variable_unit=axis.unit,
        quantity=quantity[0],
        quantity_unit=quantity[1],
        x=axis.x[told.rows],
        # Without the cause: what the fit leaves, and what the cause explains of it.
        residual=told.left + told.fitted,
        standard_uncertainty=told.standard_uncertainty,
        line_x=line_x,
        line=line[0],
        line_band=line[1],
    )


def _line(weights: FloatArray, values: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line and the half width of its 95 % band, (m,) each, from weights (k, m) of k parameters."""
    variance = np.einsum("km,kl,lm->m", weights, covariance, weights)
    return values @ weights, WITHIN_95 * np.sqrt(np.maximum(variance, 0.0))


def joint_curve(selected: Selection, scene: Scene, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the error of a joint along what it depends on; of several joints, the one that it moves most.

    Parameters
    ----------
    selected : Selection
    scene : Scene
    group : tuple of Candidate
        Picks of one cause, whose parameters are named after their joints.

    Returns
    -------
    Curve or None
        [deg]; None where the variable is unknown, or too few readings feel the joint.
    """
    by_joint: dict[int, list[str]] = {}
    for name in names_of(group):
        if "*" in name:
            return None  # a product with a moment of mass follows no torque that is known
        by_joint.setdefault(int(name.split("_")[1]) - 1, []).append(name)
    joint = max(by_joint, key=lambda one: float((effect_of(selected, by_joint[one]) ** 2).sum()))
    names = tuple(by_joint[joint])
    cell = signature_of(group[0])
    placed = _joint_axis(selected, scene, group[0], names, joint)
    if placed is None:
        return None
    axis, line_x, weights = placed
    told = seen(selected, of_joint(selected, joint) / np.rad2deg(1.0), effect_of(selected, names), axis.known)
    if told is None:
        return None
    values, covariance = values_of(selected, names)
    line, band = _line(weights, values, covariance)
    if cell.over.startswith("angle") and cell.shape in _PERIODIC:
        # Its mean is the zero of the joint: other parameters carry it, and it is no part of the shape.
        _, band = _line(weights - weights.mean(axis=1, keepdims=True), values, covariance)
    quantity = f"error of joint {joint + 1}", "deg"
    return _curve(axis, quantity, told, line_x, (np.rad2deg(line), np.rad2deg(band)))


def _joint_axis(
    selected: Selection, scene: Scene, candidate: Candidate, names: tuple[str, ...], joint: int
) -> tuple[Axis, FloatArray, FloatArray] | None:
    """Return the variable of the readings, values of it for a line (m,), and the line's weights (k, m).

    None where the torque or the direction is unknown.
    """
    torque, direction = rows_of(state_of(selected)).torque_n_mm, scene.stops.direction
    effect, cell = candidate.effect, signature_of(candidate)
    over, _, of = cell.over.partition(" of ")
    if over == "torque":
        if torque is None:
            return None
        axis = Axis(f"torque of joint {joint + 1}", "N*m", torque[:, joint] / N_MM_PER_N_M)
        line_x = axis.drawn(DRAWN)
        return (
            axis,
            line_x,
            _weights(effect, names, _there(selected, joint, torque_n_mm=N_MM_PER_N_M * line_x)),
        )
    if over == "direction":
        if direction is None:
            return None
        axis = level_axis(f"direction of joint {joint + 1}", np.sign(direction[:, joint]))
        line_x = axis.levels()
        return axis, line_x, _weights(effect, names, _there(selected, joint, direction=line_x))
    # A joint that another one moves: its own number is not that of the angle.
    source = joint if of == cell.where else int(of.removeprefix("joint ")) - 1
    orders = {order_of_wave(name) for name in names} if effect in effects_with(Trait.WAVES) else set()
    # Several orders repeat together in their common period only: 14 and 21 over a seventh of a turn.
    axis = angle_axis(scene.turn_rad[:, source], source, _common_order(orders))
    # A fast wave drawn through too few points is another, slower one.
    line_x = axis.drawn(max(DRAWN, round(_PER_WAVE * _most_waves(orders))))
    return axis, line_x, _weights(effect, names, _there(selected, source, turn_rad=np.deg2rad(line_x)))


def _there(
    selected: Selection,
    joint: int,
    *,
    turn_rad: FloatArray | float = 0.0,
    torque_n_mm: FloatArray | float = 0.0,
    direction: FloatArray | float = 0.0,
) -> Rows:
    """Return rows in which one joint (0-based) turns, carries or came from there, and all others rest."""
    rows = rows_of(state_of(selected))
    size, joints = max(map(np.size, (turn_rad, torque_n_mm, direction))), rows.turn_rad.shape[1]
    turn, torque, came = (np.zeros((size, joints)) for _ in range(3))
    turn[:, joint], torque[:, joint], came[:, joint] = turn_rad, torque_n_mm, direction
    one = np.ones(size, dtype=np.int64)
    stops = Stops(one, turn, direction=came.astype(np.int64))
    return rows._replace(stops=stops, nest=one, torque_n_mm=torque, turn_rad=turn)


def _common_order(orders: set[float]) -> float:
    """Return how many periods per turn all waves have in common; 1 where there are none."""
    if len(orders) == 1:
        return min(orders)
    return float(math.gcd(*map(int, orders))) if orders and all(map(is_whole, orders)) else 1.0


def _most_waves(orders: set[float]) -> float:
    """Return how many periods per turn the fastest wave has that shares its axis with slower ones; else 0."""
    return max(orders) if len(orders) > 1 else 0.0


def _weights(effect: str, names: tuple[str, ...], rows: Rows) -> FloatArray:
    """Weight of each parameter at its port, the first one where there are several, shape (k, m)."""
    return _by_parameter(effect_named(effect).terms(names, rows), len(names), len(rows.stops))


def _by_parameter(terms: Sequence[Term], count: int, size: int) -> FloatArray:
    """Return the weight of each parameter where it acts, shape (count, size)."""
    weights = np.zeros((count, size))
    # Backwards, so that the first port of a parameter is the one that stays.
    for term in reversed(terms):
        weights[term.parameter] = term.weight
    return weights


def shape_curve(selected: Selection, scene: Scene, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the shift of the tool over time or temperature.

    Of the motions that a cause gives the tool, the one at the moment when it acts most is the unit u; it is
    scaled to what a typical reading feels. With G = X X^T, X the columns (k, n d) of the parameters where
    they act most and a their values at that moment, the line of weights s(t) is (G a) . (v s(t)) / (a^T G a),
    times the typical shift.

    Parameters
    ----------
    selected : Selection
    scene : Scene
    group : tuple of Candidate
        Picks of one cause.

    Returns
    -------
    Curve or None
        [mm]; None where the variable is unknown, a parameter never acts, or too few readings feel it.
    """
    effect, names = group[0].effect, names_of(group)
    axis = time_axis(scene, signature_of(group[0]).over)
    if axis is None:
        return None
    state = state_of(selected)
    terms = effect_named(effect).terms(names, rows_of(state))
    largest = [float(np.ravel(term.weight)[np.argmax(np.abs(term.weight))]) for term in terms]
    # A course that is zero at every reading has no largest weight to be scaled by.
    if not all(largest):
        return None
    at_most = [term._replace(weight=most) for term, most in zip(terms, largest, strict=True)]
    columns = parameter_effects(selected, at_most, len(names))
    most = _by_parameter(at_most, len(names), 1)
    values, covariance = values_of(selected, names)
    shares = _by_parameter(terms, len(names), len(axis.x)) / most
    # The way is the one at the moment at which the cause acts most, be it one motion or several.
    gram = np.einsum("kni,lni->kl", columns, columns)
    acting = values[:, None] * shares
    energy = np.einsum("kn,kl,ln->n", acting, gram, acting)
    peak = int(np.argmax(energy))
    if energy[peak] <= 0.0:
        return None
    unit = np.tensordot(acting[:, peak], columns, 1)
    typical = float(np.median(np.linalg.norm(unit, axis=1)))
    told = seen(selected, unit / max(typical, 1e-300), effect_of(selected, names), axis.known)
    if told is None:
        return None
    line_x = axis.drawn(DRAWN)
    along = gram @ acting[:, peak] / energy[peak]
    weights = typical * along[:, None] * _weights(effect, names, _over_time(selected, axis, line_x)) / most
    quantity = "shift of the tool as this cause moves it", "mm"
    return _curve(axis, quantity, told, line_x, _line(weights, values, covariance))


def _over_time(selected: Selection, axis: Axis, line_x: FloatArray) -> Rows:
    """Return rows at these times [h] or temperatures [degC] in which all joints rest."""
    rows = rows_of(state_of(selected))
    size, joints = len(line_x), rows.turn_rad.shape[1]
    still, one = np.zeros((size, joints)), np.ones(size, dtype=np.int64)
    timed = axis.variable == "time"
    stops = Stops(
        one,
        still,
        time_s=rows.origin_s + SECONDS_PER_HOUR * line_x if timed else None,
        temperature_c=None if timed else line_x,
    )
    return rows._replace(stops=stops, nest=one, torque_n_mm=None, turn_rad=still)


def level_curve(selected: Selection, scene: Scene, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the shift along the axis of the tool that shows most of it, for each nest or mounting.

    Parameters
    ----------
    selected : Selection
    scene : Scene
    group : tuple of Candidate
        Picks of one cause.

    Returns
    -------
    Curve or None
        [mm]; None where mountings are unknown, or too few readings feel it.
    """
    names = names_of(group)
    attachment = scene.stops.attachment
    over = signature_of(group[0]).over
    if over == "constant":
        axis = level_axis("nest", scene.nest)
    elif attachment is not None:
        axis = level_axis("attachment of the tool", attachment)
    else:
        return None
    ways, effect = of_body(selected, scene.setting.robot.n_joints), effect_of(selected, names)
    found = [seen(selected, way, effect, axis.known) for way in ways]
    shown = [0.0 if told is None else float((told.fitted**2).sum()) for told in found]
    number = int(np.argmax(shown))
    told = found[number]
    if told is None:
        return None
    levels, where = np.unique(axis.x[told.rows], return_inverse=True)
    rows = [selected.fit.structure.index_of(name) for name in names]
    each = selected.fit.results[0].jacobian[rows][:, told.rows]
    way = ways[number][told.rows]
    parts = np.einsum("kni,ni->kn", each, way) / np.einsum("ni,ni->n", way, way)
    weights = np.stack([parts[:, where == level].mean(axis=1) for level in range(len(levels))], axis=1)
    quantity = f"shift along {'xyz'[number]} of the tool"
    if over == "mounting":
        # What all mountings have in common is the tool's own place, and known no better than that.
        common = weights.mean(axis=1, keepdims=True)
        weights = weights - common
        told = replace(told, fitted=told.fitted - float((values_of(selected, names)[0] @ common)[0]))
        quantity += ", about the mean of all mountings"
    return _curve(axis, (quantity, "mm"), told, levels, _line(weights, *values_of(selected, names)))


def agreement_curve(selected: Selection, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the shift that readings show along the motion by a cause, against what the cause predicts.

    Parameters
    ----------
    selected : Selection
    group : tuple of Candidate
        Picks of one cause.

    Returns
    -------
    Curve or None
        Both axes [mm]; None where too few readings feel it.
    """
    names = names_of(group)
    effect = effect_of(selected, names)
    size = np.linalg.norm(effect, axis=1)
    unit = effect / np.where(size > 0.0, size, 1.0)[:, None]
    axis = Axis("shift that this cause foretells", "mm", size)
    told = seen(selected, unit, effect, axis.known & (size > 0.0))
    if told is None:
        return None
    line_x = axis.drawn(DRAWN)
    return _curve(
        axis,
        ("shift along its way", "mm"),
        told,
        line_x,
        (line_x, WITHIN_95 * line_x * _relative(*values_of(selected, names))),
    )


def _relative(values: FloatArray, covariance: FloatArray) -> float:
    """Return the relative standard uncertainty of a cause whose parameters keep their proportions.

    Of a common factor f on v, f = 1 and u(f)^-2 = v^T C^-1 v, solved in units of the standard deviations.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    alike = covariance * np.outer(scale, scale)
    known = float((values * scale) @ np.linalg.lstsq(alike, values * scale, rcond=None)[0])
    return known**-0.5 if known > 0.0 else 0.0
