"""Loads of masses on the joints: what a change of mass, or of where it is, adds to each torque.

A mass in a frame acts by its amount at the frame's origin and by its first moment. Per joint i that carries
frame f, with g gravity and e_k the axes of the frame,

    per kg        z_i . ((o_f - o_i) x g)          per kg mm along axis k        z_i . (e_k x g)

Data see some of these four only together, so that they are told apart by what is believed: a centre of
gravity that is stated is right to some `CENTRE_WIDTH_MM`, a mass to some share of itself. With u = (dm, dc)
and p = (dm, m dc + dm c) = T u, the posterior of u is that of the data's information A and vector b alone,
and of the belief W:

    C_u = (T^T A T + W^-1)^-1        u = C_u T^T b

Own derivation; A and b are what is left of a fit's posterior once its priors are taken out.
"""

from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail
from truepose.domain.robot import LinkMass, Robot
from truepose.domain.singular_covariance import whitening_root
from truepose.effects.causes import FittedCause, Limits, Scene
from truepose.effects.ports import ParameterSpec, Port, PortKind, Rows, Term
from truepose.kinematics.frames import cross
from truepose.messages.message import Text, message

AXES = "xyz"
CENTRE_WIDTH_MM = 50.0  # belief, also: five times what a drawing is usually off by
_MASS_SHARE = 0.5  # belief: five times what a weighing or a data sheet is usually off by
_LARGEST_SHARE = 0.5  # of a stated mass: who weighs or draws a part is not off by more
_SMALLEST_KG = 1.0  # where no mass is stated


class WrongMass(NamedTuple):
    """How a mass differs from what was stated, with standard uncertainties.

    Attributes
    ----------
    extra_kg, extra_spread_kg : float
    shift_mm, shift_spread_mm : ndarray, shape (3,)
        Of the centre of gravity, in the frame that carries it.
    """

    extra_kg: float
    extra_spread_kg: float
    shift_mm: FloatArray  # (3,) of the centre of gravity, in the frame that carries it
    shift_spread_mm: FloatArray  # (3,)

    def details(self, prefix: str = "") -> tuple[Detail, ...]:
        """Return the shift of the centre of gravity."""
        return tuple(
            Detail(f"{prefix}shift of centre of gravity {axis}", float(shift), "mm", float(spread))
            for axis, shift, spread in zip(AXES, self.shift_mm, self.shift_spread_mm, strict=True)
        )


def stated_mass(robot: Robot, frame: int) -> LinkMass:
    """Return what is stated for a frame: the sum of its masses at their common centre of gravity.

    Parameters
    ----------
    robot : Robot
    frame : int
        0-based.

    Returns
    -------
    LinkMass
        Of 0 kg where none is.
    """
    # Data see only their sum: two masses of one frame move alike.
    masses = [mass for mass in robot.masses if mass.frame == frame + 1]
    total = sum(mass.mass_kg for mass in masses)
    if total <= 0.0:
        return LinkMass(frame + 1, 0.0, (0.0, 0.0, 0.0))
    x, y, z = (sum(mass.mass_kg * mass.centre_of_gravity_mm[k] for mass in masses) / total for k in range(3))
    return LinkMass(frame + 1, total, (x, y, z))


def mass_limits(stated: LinkMass) -> Limits | None:
    """Return by how much a mass may differ from what is stated: half of it; None where nothing is."""
    most_kg = _LARGEST_SHARE * stated.mass_kg
    return Limits(-most_kg, most_kg, message("limits.mass")) if most_kg > 0.0 else None


def mass_specs(
    names: tuple[str, str, str, str], stated: LinkMass
) -> tuple[ParameterSpec, ParameterSpec, ParameterSpec, ParameterSpec]:
    """Return the parameters of a mass (its amount and three first moments) by their names.

    Widths: half of the stated mass, 0.5 kg where none is stated; of a moment the mass times 50 mm and what
    the amount's own width makes at the stated centre.

    Parameters
    ----------
    names : tuple of four str
        Mass, then moments along x, y, z.
    stated : LinkMass
    """
    mass, *moments = names
    kilograms = stated.mass_kg or _SMALLEST_KG
    width = kilograms * _MASS_SHARE
    reach = kilograms * CENTRE_WIDTH_MM + width * float(np.linalg.norm(stated.centre_of_gravity_mm))
    x, y, z = (ParameterSpec(moment, "kg*mm", 0.0, reach) for moment in moments)
    return ParameterSpec(mass, "kg", 0.0, width), x, y, z


def mass_terms(parameter: int, frame: int, quantity: str, rows: Rows) -> list[Term]:
    """Return how mass in a frame loads the joints up to it.

    Parameters
    ----------
    parameter : int
        Index that the terms carry.
    frame : int
        0-based joint in whose frame the mass is fixed.
    quantity : str
        `mass`: mass at the frame's origin [kg]; `x`, `y` or `z`: first moment along that axis [kg mm].
    rows : Rows

    Returns
    -------
    list of Term
        Torques [N mm] per kg or kg mm, one for each joint that carries the frame.
    """
    chain = rows.chain
    terms = []
    # The frame's own joint too: a mass on its axis has no moment about it, but a first moment across the axis
    # has.
    for joint in range(frame + 1):
        if quantity == "mass":
            lever = chain.origin[frame] - chain.origin[joint]
        else:
            lever = chain.rotation[frame, :, :, AXES.index(quantity)]
        torque = np.einsum("ni,ni->n", chain.z[joint], cross(lever, rows.gravity_m_s2))
        terms.append(Term(parameter, Port(PortKind.TORQUE, joint), torque))
    return terms


def unseen_masses(scene: Scene) -> Text | None:
    """Return why wrong masses cannot be seen: they show only through springs that gravity loads.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Text or None
        None where they can.
    """
    # What was measured is what the arm weighs, whatever anybody stated.
    if scene.setting.torque_source == "measured":
        return message("unseen.torques_measured")
    if scene.setting.torque_source == "unknown":
        return message("unseen.masses_unknown")
    if not np.any(scene.softness_rad_per_n_mm > 0.0):
        return message("unseen.no_springs")
    return None


def wrong_mass(fitted: FittedCause, specs: tuple[ParameterSpec, ...], stated: LinkMass) -> WrongMass:
    """Tell amount and centre of gravity apart, by the formulas of the module's head.

    What the data say of the four parameters is their posterior less the priors of the fit; to it comes
    the belief about amount and centre of gravity, in which a heavier part has a larger moment too.

    Parameters
    ----------
    fitted : FittedCause
        With these four parameters among its own.
    specs : tuple of ParameterSpec
        Mass, then moments along x, y, z, as they were fitted.
    stated : LinkMass
    """
    order = [fitted.names.index(spec.name) for spec in specs]
    # The fit's own priors hold the four apart by widths that know nothing of each other; here amount and
    # place are.
    information, pull = _from_data(
        fitted.values[order],
        fitted.covariance[np.ix_(order, order)],
        np.array([spec.prior_width for spec in specs]),
    )
    kilograms = stated.mass_kg or _SMALLEST_KG
    to_moments = np.diag([1.0, kilograms, kilograms, kilograms])
    to_moments[1:, 0] = stated.centre_of_gravity_mm
    belief = np.array([_MASS_SHARE * kilograms, *(CENTRE_WIDTH_MM,) * 3])
    covariance = np.linalg.inv(to_moments.T @ information @ to_moments + np.diag(belief**-2))
    mean = covariance @ to_moments.T @ pull
    spread = np.sqrt(np.diag(covariance))
    return WrongMass(float(mean[0]), float(spread[0]), mean[1:], spread[1:])


def _from_data(
    values: FloatArray, covariance: FloatArray, widths: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Information matrix and vector of the data alone, of a posterior whose priors had mean 0.

    A = C^-1 - diag(w^-2), b = C^-1 m. In units of the widths the prior's information is 1 along every
    direction, so that what the data gain is each eigenvalue less 1.

    Parameters
    ----------
    values : ndarray, shape (k,)
    covariance : ndarray, shape (k, k)
    widths : ndarray, shape (k,)
    """
    # In units of the priors' widths: kilograms and kilogram-millimetres have one scale, and so has rounding.
    # By a root of the inverse: a quantity that is known exactly leaves a covariance without one.
    root = whitening_root(covariance / np.outer(widths, widths))
    precision = root.T @ root
    size, direction = np.linalg.eigh(precision)
    gained = np.maximum(size - 1.0, 0.0)  # along directions that the data do not see, rounding may go below
    # Along the others the vector is rounding as well, and would be blown up by the belief that comes to it.
    seen = gained > 0.0
    pull = direction.T @ (precision @ (values / widths))
    scale = 1.0 / widths
    information = scale[:, None] * (direction * gained @ direction.T) * scale
    return information, scale * (direction @ np.where(seen, pull, 0.0))
