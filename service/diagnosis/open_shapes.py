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

from service.domain.arrays import FloatArray
from service.effects.joint_gain import NAME as GAIN
from service.effects.joint_harmonics import NAME as HARMONICS
from service.effects.joint_harmonics import wave_specs
from service.effects.ports import ParameterSpec
from service.identification.observations import linearise_blocks
from service.identification.robust import RobustFit
from service.identification.solver import Solution, posterior_covariance

_ORDERS = range(1, 13)  # a gap of the angles that is narrower than these waves leaves nothing open


def with_open_shapes(fit: RobustFit, turn_rad: FloatArray) -> RobustFit:
    """Return a fit whose covariance holds what the readings leave open of the shapes found.

    Parameters
    ----------
    fit : RobustFit
        Of a model with some waves or gains of joints; without them it comes back as it is.
    turn_rad : ndarray, shape (n, J)
        Where the joints were in the readings.
    """
    specs = _open_specs(fit, np.ptp(turn_rad, axis=0))
    if not specs:
        return fit
    structure = fit.structure.extended(HARMONICS, specs)
    values = np.concatenate([fit.values, np.zeros(len(specs))])
    point = linearise_blocks(structure, fit.blocks, values, None)
    covariance = posterior_covariance(point.jacobian, 1.0 / structure.prior_widths**2)
    solution = Solution(values, covariance, fit.solution.converged, fit.solution.iterations, point)
    return replace(fit, structure=structure, solution=solution)


def _open_specs(fit: RobustFit, way_rad: FloatArray) -> tuple[ParameterSpec, ...]:
    known = set(fit.structure.names)
    return tuple(
        spec._replace(prior_width=float(width))
        for joint, width in enumerate(_widths_rad(fit, way_rad))
        if width > 0.0
        for order in _ORDERS
        for spec in wave_specs(joint, float(order))
        if spec.name not in known
    )


def _widths_rad(fit: RobustFit, way_rad: FloatArray) -> FloatArray:
    """Return the standard deviation of a further wave's sine and cosine on each joint: the largest found."""
    largest = np.zeros(fit.structure.robot.n_joints)
    for name, owner, value in zip(fit.structure.names, fit.structure.owners, fit.values, strict=True):
        if owner == HARMONICS:
            joint = int(name.split("_")[1]) - 1
            size = abs(float(value))
        elif owner == GAIN:
            joint = int(name.rsplit("_", 1)[-1]) - 1
            size = abs(float(value)) * way_rad[joint] / np.sqrt(12.0)
        else:
            continue
        largest[joint] = max(largest[joint], size)
    return largest
