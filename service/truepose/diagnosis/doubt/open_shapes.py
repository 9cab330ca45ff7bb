"""What the shape of a joint's error may be where no reading was taken: the model's uncertainty says so.

Waves are chosen because they fit the angles that were measured. Other orders would fit them nearly as well
and go another way in between. So every order stays in the covariance of the model, with the value 0 and the
size of what was found as its width: where readings are, they hold it; in a gap of the angles, and beyond
them, it is as open as it was.

References
----------
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, section 2.1 (a linear
model in fixed functions with a normal prior of their weights).
"""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.joints.joint_harmonics import NAME as HARMONICS
from truepose.effects.joints.joint_harmonics import joint_of_wave, order_of_wave, wave_specs
from truepose.effects.ports import ParameterSpec
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.solver import Solution, posterior_covariance
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import linearise_blocks

_ORDERS = range(1, 13)  # a gap of the angles that is narrower than these waves leaves nothing open


def with_open_shapes(fit: RobustFit, found: RobustFit) -> RobustFit:
    """Return a fit whose covariance holds what the readings leave open of the shapes found.

    Parameters
    ----------
    fit : RobustFit
        Of a model with waves of some joints; without them it comes back as it is.
    found : RobustFit
        Of the findings alone, as free as their readings are: how large waves are is told by both.
    """
    widths_rad = np.maximum(_widths_rad(fit), _widths_rad(found))
    if not widths_rad.any():
        return fit
    specs = _open_specs(fit, widths_rad)
    structure = _widened(fit.structure, found.structure, widths_rad).extended(HARMONICS, specs)
    values = np.concatenate([fit.values, np.zeros(len(specs))])
    point = linearise_blocks(structure, fit.blocks, values, None)
    covariance = posterior_covariance(point.jacobian, 1.0 / structure.prior_widths**2)
    solution = Solution(values, covariance, fit.solution.converged, fit.solution.iterations, point)
    return replace(fit, structure=structure, solution=solution)


def _widened(structure: Structure, found: Structure, widths_rad: FloatArray) -> Structure:
    """Return the structure with its own slow waves as open as others of their joint, fast ones as when found.

    The waves of a curve share one width, which is that of all orders: a slow one may be larger.
    """
    free = {spec.name: spec.prior_width for spec in found.specs}

    def opened(spec: ParameterSpec, owner: str) -> ParameterSpec:
        if owner != HARMONICS:
            return spec
        slow = order_of_wave(spec.name) in _ORDERS
        width = float(widths_rad[joint_of_wave(spec.name)]) if slow else free.get(spec.name, 0.0)
        return spec._replace(prior_width=max(spec.prior_width, width))

    specs = tuple(opened(spec, owner) for spec, owner in zip(structure.specs, structure.owners, strict=True))
    return replace(structure, specs=specs)


def _open_specs(fit: RobustFit, widths_rad: FloatArray) -> tuple[ParameterSpec, ...]:
    known = set(fit.structure.names)
    return tuple(
        spec._replace(prior_width=float(width))
        for joint, width in enumerate(widths_rad)
        if width > 0.0
        for order in _ORDERS
        for spec in wave_specs(joint, float(order))
        if spec.name not in known
    )


def _widths_rad(fit: RobustFit) -> FloatArray:
    """Return the standard deviation of a further wave's sine and cosine on each joint.

    That of the largest one found, with what is not known of it.
    """
    largest = np.zeros(fit.structure.robot.n_joints)
    sizes = np.hypot(fit.values, np.sqrt(np.diag(fit.solution.covariance)))
    for name, owner, size in zip(fit.structure.names, fit.structure.owners, sizes.tolist(), strict=True):
        if owner == HARMONICS:
            joint = joint_of_wave(name)
            largest[joint] = max(largest[joint], size)
    return largest
