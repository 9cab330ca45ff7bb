"""What is known only within a certificate: tool nests and the registration of the world frame.

They are held at their stated values while identifying; their uncertainty is carried into the covariance
of the parameters afterwards (consider parameters: B. D. Tapley, B. E. Schutz, G. H. Born,
Statistical Orbit Determination, 2004, chapter 6).
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, FixedNestReadings
from truepose.domain.robot import FixedNest, WorldRegistration
from truepose.identification.fit.robust import RobustFit
from truepose.identification.observations.blocks import Block, BlockResult, OrientationBlock, PositionBlock
from truepose.identification.observations.fixed_nests import ReferenceBlock
from truepose.kinematics.frames import cross_matrix


@dataclass(frozen=True, slots=True)
class Considered:
    """Covariances of the parameters, term by term."""

    readings: FloatArray  # (P, P) from the observations and the priors
    nests: FloatArray  # (P, P) added by the certified tool nests
    registration: FloatArray  # (P, P) added by the registration of the world frame

    @property
    def total(self) -> FloatArray:
        """Sum of the three, shape (P, P)."""
        return self.readings + self.nests + self.registration


def considered(campaign: Campaign, fit: RobustFit) -> Considered:
    """Carry the certified uncertainties into the covariance of the parameters."""
    covariance = fit.solution.covariance
    nothing = np.zeros_like(covariance)
    if not isinstance(fit.blocks[0], PositionBlock):
        return Considered(covariance, nothing, nothing)
    gain = _Gain(fit)
    nests = gain(_nest_sensitivities(campaign, fit))
    registration = world_registration(campaign)
    if registration is None:
        return Considered(covariance, nests @ nests.T, nothing)
    frame = gain([
        _frame_sensitivity(result, block) for result, block in zip(fit.results, fit.blocks, strict=True)
    ])
    return Considered(covariance, nests @ nests.T, frame @ registration.covariance @ frame.T)


class _Gain:
    """Change of the parameters per change of something held: -C J^T W S, summed over the blocks."""

    def __init__(self, fit: RobustFit) -> None:
        self._results = fit.results
        self._left = [fit.solution.covariance @ result.white_jacobian for result in fit.results]  # (P, n d)

    def __call__(self, sensitivities: list[FloatArray]) -> FloatArray:
        """Return the gain, shape (P, S), from one sensitivity (S, n, d) per block."""
        gain = np.zeros((len(self._left[0]), len(sensitivities[0])))
        for left, result, sensitivity in zip(self._left, self._results, sensitivities, strict=True):
            white = result.whitening.apply(sensitivity).reshape(len(sensitivity), left.shape[1])
            gain -= left @ white.T
        return gain


def _nest_sensitivities(campaign: Campaign, fit: RobustFit) -> list[FloatArray]:
    """Return the motion of each prediction per standard uncertainty of each certified nest coordinate.

    One array of shape (S, n, 3) per block; where a nest sits does not turn the tool.
    """
    position = _nest_sensitivity(campaign, fit.results[0])
    others = [np.zeros((len(position), *result.residual.shape)) for result in fit.results[1:]]
    return [position, *others]


def _nest_sensitivity(campaign: Campaign, result: BlockResult) -> FloatArray:
    last = result.state.chain.end_rotation
    rows = []
    for number, nest in enumerate(campaign.nests, start=1):
        if nest.centre_mm is None or not nest.standard_uncertainty_mm:
            continue
        here = (result.state.targets.nest == number)[:, None]
        rows += [np.where(here, last[:, :, k], 0.0) * nest.standard_uncertainty_mm for k in range(3)]
    return np.array(rows).reshape(-1, len(last), 3)


def _frame_sensitivity(result: BlockResult, block: Block) -> FloatArray:
    """Return the motion of each prediction, in the frame of the readings, per small motion of the world.

    Shape (6, n, 3): three shifts, three turns; a turn moves positions and turns orientations. The readings
    of fixed nests have the world's error among their own parameters and carry nothing into the others.
    """
    if isinstance(block, ReferenceBlock):
        return np.zeros((6, *result.residual.shape))
    points = result.state.position_mm
    shifts = np.broadcast_to(np.eye(3)[:, None, :], (3, len(points), 3))
    if isinstance(block, OrientationBlock):
        return np.concatenate([np.zeros_like(shifts), shifts])
    turns = np.stack([np.cross(axis, points) for axis in np.eye(3)])
    return np.concatenate([shifts, turns])


def world_registration(campaign: Campaign) -> WorldRegistration | None:
    """Return how well the world frame is known: as stated, else from the looks at the fixed nests."""
    if campaign.registration is not None:
        return campaign.registration
    if campaign.reference is None or len(campaign.fixed_nests) < 3:
        return None
    return WorldRegistration(_registration_covariance(campaign.reference, campaign.fixed_nests))


def _registration_covariance(readings: FixedNestReadings, nests: tuple[FixedNest, ...]) -> FloatArray:
    normal = np.zeros((6, 6))
    for number, nest in enumerate(nests, start=1):
        here = readings.fixed_nest == number
        if not here.any():
            continue
        mean_variance = 1.0 / float((1.0 / readings.standard_uncertainty_mm[here] ** 2).sum())
        variance = mean_variance + nest.standard_uncertainty_mm**2
        motion = np.hstack([np.eye(3), -cross_matrix(np.array(nest.centre_mm))])
        normal += motion.T @ motion / variance
    return np.asarray(np.linalg.pinv(normal, rcond=1e-12))
