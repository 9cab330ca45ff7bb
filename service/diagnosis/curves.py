"""Curves: residuals along one variable, with what was fitted to them.

What a cause does to one reading is a shift of the point along a known direction; the residual's part along
it, divided by what one unit does, is that reading's own estimate of the cause there.
"""

from dataclasses import dataclass

import numpy as np

from service.diagnosis.columns import term_columns
from service.diagnosis.left import Depends
from service.diagnosis.selection import Selected
from service.domain.arrays import FloatArray
from service.domain.diagnosis import Curve
from service.effects.causes import Candidate, Scene
from service.effects.ports import Port, PortKind, Term

_SMOOTH = 5  # cosines of a smooth curve
_DRAWN = 200  # points of a line
_SLOW_ORDER = 6.0  # faster waves are drawn over one period
_ANGLES = frozenset({"joint_gain", "joint_harmonics", "joint_coupling"})
_LOADS = frozenset({"compliance", "compliance_nonlinear"})
_TIMES = frozenset({"base_drift", "base_shift", "instrument_drift"})


@dataclass(frozen=True, slots=True)
class _Axis:
    variable: str
    unit: str
    x: FloatArray  # (n,)


def finding_curve(selected: Selected, scene: Scene, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the residuals without a finding, and the finding over them; None where no one line shows it."""
    pick = group[0]
    joint = _joint(pick)
    if joint is not None and (pick.effect in _ANGLES | _LOADS or pick.effect == "backlash"):
        return _joint_curve(selected, scene, group, joint)
    axis = _axis_of(pick, scene)
    return None if axis is None else _shift_curve(selected, group, axis)


def _joint(pick: Candidate) -> int | None:
    return int(pick.subject.split()[1]) - 1 if pick.subject.startswith("joint ") else None


def _joint_curve(selected: Selected, scene: Scene, group: tuple[Candidate, ...], joint: int) -> Curve | None:
    """Error of one joint along what it depends on."""
    effect = _effect_of(selected, group)
    unit = _unit_angle(selected, joint)
    rows = _rows(unit)
    squares = np.einsum("ni,ni->n", rows, rows)
    if not (squares > 0.0).all():
        return None
    fitted = np.einsum("ni,ni->n", _rows(effect), rows) / squares
    seen = np.einsum("ni,ni->n", _first(selected, selected.fit.solution.final.residual), rows) / squares
    axis = _joint_axis(scene, group, joint)
    return _curve(
        axis,
        f"error of joint {joint + 1}",
        "deg",
        np.rad2deg(seen + fitted),
        np.rad2deg(squares**-0.5),
        np.rad2deg(fitted),
    )


def _joint_axis(scene: Scene, group: tuple[Candidate, ...], joint: int) -> _Axis:
    pick = group[0]
    if pick.effect in _LOADS and scene.torque_n_mm is not None:
        return _Axis(f"torque of joint {joint + 1}", "N*m", scene.torque_n_mm[:, joint] / 1e3)
    if pick.effect == "backlash" and scene.stops.direction is not None:
        return _Axis(
            f"direction of joint {joint + 1}", "", np.sign(scene.stops.direction[:, joint]).astype(float)
        )
    source = int(pick.names[0].split("_")[2]) - 1 if pick.effect == "joint_coupling" else joint
    angle = np.rad2deg(scene.turn_rad[:, source])
    if len(group) == 1 and pick.effect == "joint_harmonics" and pick.variant > _SLOW_ORDER:
        return _Axis(
            f"angle of joint {source + 1} within one period", "deg", np.mod(angle, 360.0 / pick.variant)
        )
    return _Axis(f"angle of joint {source + 1}", "deg", angle)


def _axis_of(pick: Candidate, scene: Scene) -> _Axis | None:
    stops = scene.stops
    if pick.effect in _TIMES and stops.time_s is not None:
        return _Axis("time", "h", (stops.time_s - scene.origin_s) / 3600.0)
    if pick.effect == "thermal_growth" and stops.temperature_c is not None:
        return _Axis("temperature", "degC", stops.temperature_c)
    if pick.effect == "tool_reseating" and stops.attachment is not None:
        return _Axis("attachment of the tool", "", stops.attachment.astype(float))
    if pick.effect == "nest_offset":
        return _Axis("nest", "", scene.nest.astype(float))
    return None


def _shift_curve(selected: Selected, group: tuple[Candidate, ...], axis: _Axis) -> Curve | None:
    """Shift of the readings along the way on which the finding moves them."""
    effect = _rows(_effect_of(selected, group))
    whole = np.linalg.norm(effect, axis=1)
    moved = whole > 0.02 * float(whole.max(initial=0.0))
    if not moved.any() or not np.isfinite(axis.x).all():
        return None
    residual = _first(selected, selected.fit.solution.final.residual)
    typical = _typical_mm(selected)
    along = np.einsum("ni,ni->n", residual, effect) / np.where(moved, whole, 1.0)
    shown = _Axis(axis.variable, axis.unit, axis.x[moved])
    fitted = whole[moved] * typical
    noise = np.full(int(moved.sum()), typical)
    return _curve(
        shown,
        "shift of the tool as this cause moves it",
        "mm",
        along[moved] * typical + fitted,
        noise,
        fitted,
    )


def remaining_curve(selected: Selected, scene: Scene, depends: Depends) -> Curve | None:
    """Return a smooth curve with its band through what is left, along what it depends on."""
    if depends.joint is None:
        return None
    axis = _remaining_axis(scene, depends)
    rows = _rows(_unit_angle(selected, depends.joint))
    squares = np.einsum("ni,ni->n", rows, rows)
    if axis is None or not (squares > 0.0).all():
        return None
    seen = np.einsum("ni,ni->n", _first(selected, selected.fit.solution.final.residual), rows) / squares
    quantity = f"error of joint {depends.joint + 1}"
    return _smooth(axis, quantity, np.rad2deg(seen), np.rad2deg(squares**-0.5))


def _remaining_axis(scene: Scene, depends: Depends) -> _Axis | None:
    assert depends.joint is not None
    if depends.kind == "torque":
        if scene.torque_n_mm is None:
            return None
        return _Axis(depends.variable, "N*m", scene.torque_n_mm[:, depends.joint] / 1e3)
    if depends.kind == "direction":
        if scene.stops.direction is None:
            return None
        return _Axis(depends.variable, "", np.sign(scene.stops.direction[:, depends.joint]).astype(float))
    if depends.kind != "angle":
        return None
    angle = np.rad2deg(scene.turn_rad[:, depends.joint])
    if depends.order > _SLOW_ORDER:
        return _Axis(f"{depends.variable} within one period", "deg", np.mod(angle, 360.0 / depends.order))
    return _Axis(depends.variable, "deg", angle)


def _smooth(axis: _Axis, quantity: str, seen: FloatArray, uncertainty: FloatArray) -> Curve:
    low, high = float(axis.x.min()), float(axis.x.max())
    line_x = np.linspace(low, high, _DRAWN)
    design, drawn = (_cosines((x - low) / max(high - low, 1e-12)) for x in (axis.x, line_x))
    weights = 1.0 / uncertainty**2
    precision = design.T @ (weights[:, None] * design) + 1e-9 * np.eye(design.shape[1]) * weights.sum()
    covariance = np.linalg.inv(precision)
    coefficients = covariance @ (design.T @ (weights * seen))
    band = 1.96 * np.sqrt(np.einsum("ni,ij,nj->n", drawn, covariance, drawn))
    return Curve(
        axis.variable,
        axis.unit,
        quantity,
        "deg",
        axis.x,
        seen,
        uncertainty,
        line_x,
        drawn @ coefficients,
        band,
    )


def _cosines(share: FloatArray) -> FloatArray:
    return np.stack([np.cos(np.pi * k * share) for k in range(_SMOOTH + 1)], axis=1)


def _curve(
    axis: _Axis, quantity: str, unit: str, seen: FloatArray, uncertainty: FloatArray, fitted: FloatArray
) -> Curve:
    order = np.argsort(axis.x, kind="stable")
    thin = order[:: max(1, len(order) // _DRAWN)]
    return Curve(
        axis.variable,
        axis.unit,
        quantity,
        unit,
        axis.x,
        seen,
        uncertainty,
        axis.x[thin],
        fitted[thin],
        np.zeros(len(thin)),
    )


def _effect_of(selected: Selected, group: tuple[Candidate, ...]) -> FloatArray:
    """Whitened shift of the first block's readings by a group, shape (n, d)."""
    fit = selected.fit
    rows = [fit.structure.index_of(name) for pick in group for name in pick.names]
    return _first(selected, fit.values[rows] @ fit.solution.final.jacobian[rows])


def _first(selected: Selected, stacked: FloatArray) -> FloatArray:
    residual = selected.fit.results[0].residual
    return stacked[: residual.size].reshape(residual.shape)


def _rows(array: FloatArray) -> FloatArray:
    return array


def _unit_angle(selected: Selected, joint: int) -> FloatArray:
    """Whitened shift of the first block's readings per angle of a joint, shape (n, d)."""
    fit = selected.fit
    terms = [
        (Term(0, Port(PortKind.THETA, joint), np.ones(len(result.state.targets))),) for result in fit.results
    ]
    return _first(selected, term_columns(fit, terms, 1)[0])


def _typical_mm(selected: Selected) -> float:
    """Standard deviation per axis that whitening divides by, typically [mm]."""
    block = selected.fit.blocks[0]
    return float(np.sqrt(np.median(block.component_variance()) + block.scatter_mm**2))
