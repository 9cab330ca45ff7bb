"""Curves and spectra of findings and residuals, through fitted readings and those left out.

What is left gets a smooth line. A dependence says on what, not in which way: of the ways in which the
readings could move, the one is shown along which the line takes most out of the residuals.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.baseline_fit import Start, scene_at
from truepose.diagnosis.cause_curves import (
    DRAWN,
    N_MM_PER_N_M,
    Axis,
    agreement_curve,
    angle_axis,
    joint_curve,
    level_axis,
    level_curve,
    shape_curve,
    time_axis,
)
from truepose.diagnosis.evidence.held_out_errors import validation_block
from truepose.diagnosis.evidence.residual_structure import Relation
from truepose.diagnosis.evidence.sensitivities import (
    Sensitivities,
    of_body,
    of_joint,
    seen,
    state_of,
    values_of,
)
from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Curve, CurvePoints, Spectrum
from truepose.domain.singular_covariance import solve_singular
from truepose.effects.causes import Candidate, FittedCause, Scene
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.effects.signatures import curve_kind
from truepose.effects.waves import spectrum
from truepose.identification.distributions import WITHIN_95
from truepose.identification.model.evaluation import rows_of
from truepose.identification.observations.blocks import linearise_blocks

_SMOOTH = 5  # cosines of a smooth curve


DRAWN_BY = {
    "joint": joint_curve,
    "shift": shape_curve,
    "level": level_curve,
}


class _Way(NamedTuple):
    """A motion of the readings, per unit of a quantity."""

    quantity: str
    unit: str
    per_unit_mm: FloatArray  # (n, d)


def finding_curve(selected: Selection, scene: Scene, group: tuple[Candidate, ...]) -> Curve | None:
    """Return the residuals without a finding, and the finding over them.

    Parameters
    ----------
    selected : Selection
    scene : Scene
    group : tuple of Candidate
        Picks of the finding.

    Returns
    -------
    Curve or None
        None where no reading feels it. Where the cause's own variable is unknown, the curve is that of
        agreement.
    """
    draw = DRAWN_BY.get(curve_kind(group[0].effect))
    own = None if draw is None else draw(selected, scene, group)
    return own or agreement_curve(selected, group)


def remaining_curve(selected: Selection, scene: Scene, depends: Relation) -> Curve | None:
    """Return a smooth curve with its band through what is left, along what it depends on.

    Parameters
    ----------
    selected : Selection
    scene : Scene
    depends : Relation

    Returns
    -------
    Curve or None
        Along the axis, and of the motion, that explain most of the residuals; None where there is none.
    """
    drawn = [
        found
        for axis in _axes(selected, scene, depends)
        for way in _ways(selected, scene, depends)
        if (found := _smooth(selected, axis, way)) is not None
    ]
    return max(drawn, key=lambda found: found[0])[1] if drawn else None


def _axes(selected: Selection, scene: Scene, depends: Relation) -> Iterator[Axis]:
    """Yield the variables along which a dependence may be drawn; a place has three."""
    stops, joint = scene.stops, depends.joint
    torque = rows_of(state_of(selected)).torque_n_mm
    if depends.kind in ("angle", "coupling") and joint is not None:
        yield angle_axis(scene.turn_rad[:, joint], joint, depends.order)
    elif depends.kind == "torque" and joint is not None and torque is not None:
        yield Axis(depends.variable, "N*m", torque[:, joint] / N_MM_PER_N_M)
    elif depends.kind == "direction" and joint is not None and stops.direction is not None:
        yield level_axis(depends.variable, np.sign(stops.direction[:, joint]))
    elif depends.kind == "attachment" and stops.attachment is not None:
        yield level_axis("attachment of the tool", stops.attachment)
    elif depends.kind == "nest":
        yield level_axis("nest", scene.nest)
    elif depends.kind == "place":
        for number, place_mm in enumerate(scene.chain.end_origin.T):
            yield Axis(f"place along {'xyz'[number]}", "mm", place_mm)
    elif depends.kind in ("time", "temperature"):
        axis = time_axis(scene, depends.kind)
        if axis is not None:
            yield axis


def _ways(selected: Selection, scene: Scene, depends: Relation) -> Iterator[_Way]:
    """Yield the motions that a dependence may cause: of joints, else shifts of base and tool."""
    joints = scene.setting.robot.n_joints
    if depends.joint is not None:
        own = depends.kind != "coupling"
        for joint in [depends.joint] if own else [j for j in range(joints) if j != depends.joint]:
            yield _Way(f"error of joint {joint + 1}", "deg", np.deg2rad(of_joint(selected, joint)))
        return
    for body, whose in ((0, "base"), (joints, "tool")):
        for number, way in enumerate(of_body(selected, body)):
            yield _Way(f"shift along {'xyz'[number]} of the {whose}", "mm", way)


def _smooth(selected: Selection, axis: Axis, way: _Way) -> tuple[float, Curve] | None:
    """Return what a smooth line takes out of the residuals (sum of squares), and the curve."""
    told = seen(selected, way.per_unit_mm, np.zeros_like(way.per_unit_mm), axis.known)
    if told is None:
        return None
    x = axis.x[told.rows]
    line_x = np.unique(x) if axis.stepped else np.linspace(float(x.min()), float(x.max()), DRAWN)
    coefficients, covariance = _fitted(_design(axis, x, line_x), told)
    drawn = _design(axis, line_x, line_x)
    band = WITHIN_95 * np.sqrt(np.einsum("ni,ij,nj->n", drawn, covariance, drawn))
    curve = Curve(
        variable=axis.variable,
        variable_unit=axis.unit,
        quantity=way.quantity,
        quantity_unit=way.unit,
        x=x,
        residual=told.left,
        standard_uncertainty=told.standard_uncertainty,
        line_x=line_x,
        line=drawn @ coefficients,
        line_band=band,
    )
    # c^T C^-1 c, the sum of squares that a line through nothing would leave more; what it is compared by.
    taken = float(coefficients @ solve_singular(covariance, coefficients))
    return taken, curve


def _fitted(design: FloatArray, told: Sensitivities) -> tuple[FloatArray, FloatArray]:
    """Return the coefficients (k,) of weighted least squares, and their covariance (k, k).

    The band is as wide as the readings scatter, if that is wider than they state.
    """
    weights = told.standard_uncertainty**-2.0
    # Readings at few different values leave cosines undetermined; they then stay at 0 instead of dividing by
    # it.
    ridge = 1e-9 * float(weights.sum()) * np.eye(design.shape[1])
    covariance = np.linalg.inv(design.T @ (weights[:, None] * design) + ridge)
    coefficients = covariance @ (design.T @ (weights * told.left))
    freedom = max(len(told.left) - design.shape[1], 1)
    scatter = float(weights @ (told.left - design @ coefficients) ** 2) / freedom
    return coefficients, covariance * max(scatter, 1.0)


def _design(axis: Axis, x: FloatArray, line_x: FloatArray) -> FloatArray:
    """Return the columns of a smooth line at x (n,): a step for each level, else cosines, shape (n, k)."""
    if axis.stepped:
        return np.asarray(x[:, None] == line_x, dtype=float)
    share = (x - line_x[0]) / max(float(line_x[-1] - line_x[0]), 1e-12)
    return np.stack([np.cos(np.pi * k * share) for k in range(_SMOOTH + 1)], axis=1)


def finding_spectrum(selected: Selection, group: tuple[Candidate, ...]) -> Spectrum | None:
    """Return the amplitudes of a finding's waves.

    Parameters
    ----------
    selected : Selection
    group : tuple of Candidate
        Picks of the finding.

    Returns
    -------
    Spectrum or None
        None where it is no sum of several waves.
    """
    if group[0].effect not in effects_with(Trait.WAVES):
        return None
    names = names_of(group)
    found = spectrum(FittedCause(names, *values_of(selected, names)))
    return found if len(found.order) > 1 else None


# Other readings give the quantity of their curves another size or zero: they cannot stand in one picture.
_MEASURED_BY_THEIR_READINGS = frozenset({"shift", "level"})


@dataclass(frozen=True, slots=True)
class ValidationFit:
    """The extended model at the validation readings instead of those that it was fitted to.

    Attributes
    ----------
    selected : Selection
        With these readings as its first block; its parameters are not fitted to them.
    scene : Scene
        Of these readings.
    """

    selected: Selection
    scene: Scene

    def added_to(self, curve: Curve, group: tuple[Candidate, ...]) -> Curve:
        """Return a curve with these readings in it, where they can be drawn on the same axes.

        Parameters
        ----------
        curve : Curve
        group : tuple of Candidate
            Picks of the finding that it is of.

        Returns
        -------
        Curve
        """
        if curve_kind(group[0].effect) in _MEASURED_BY_THEIR_READINGS:
            return curve
        there = finding_curve(self.selected, self.scene, group)
        if there is None or (there.variable, there.quantity) != (curve.variable, curve.quantity):
            return curve
        return replace(curve, unseen=CurvePoints(there.x, there.residual, there.standard_uncertainty))


def unseen_of(start: Start, selected: Selection) -> ValidationFit | None:
    """Return the extended model at the validation readings.

    Parameters
    ----------
    start : Start
    selected : Selection

    Returns
    -------
    ValidationFit or None
        None where there are none.
    """
    block = validation_block(start.campaign, selected.fit.structure)
    if block is None:
        return None
    fit = selected.fit
    there = linearise_blocks(fit.structure, (block,), fit.values, None)
    moved = replace(fit, blocks=(block,), solution=replace(fit.solution, final=there), gross=fit.gross[:1])
    scene = scene_at(start.problem, there.results[0].state, np.zeros(0))
    return ValidationFit(replace(selected, fit=moved), scene)


def curve_with_unseen(
    curve: Curve | None, unseen: ValidationFit | None, group: tuple[Candidate, ...]
) -> Curve | None:
    """Return the curve of a finding with the validation readings, where both are there.

    Parameters
    ----------
    curve : Curve or None
    unseen : ValidationFit or None
    group : tuple of Candidate
        Picks of the finding.

    Returns
    -------
    Curve or None
    """
    return curve if curve is None or unseen is None else unseen.added_to(curve, group)
