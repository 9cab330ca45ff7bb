"""What is known only within a certificate: tool nests and the registration of the world frame.

They are held at their stated values while identifying; their uncertainty is carried into the covariance
of the parameters afterwards (consider parameters: B. D. Tapley, B. E. Schutz, G. H. Born,
Statistical Orbit Determination, 2004, chapter 6).
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Campaign, FixedNestReadings
from truepose.domain.robot import FixedNest, WorldRegistration
from truepose.effects.tool.tool_certificate import moves
from truepose.identification.fit.robust import RobustFit
from truepose.identification.observations.blocks import Block, BlockResult
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
    covariance, gain = fit.solution.covariance, _Gain(fit)
    each = list(zip(fit.blocks, fit.results, strict=True))
    held = _held_nests(campaign, fit)
    nests = gain([_nest_sensitivity(held, block, result) for block, result in each])
    registration = world_registration(campaign)
    if registration is None:
        return Considered(covariance, nests @ nests.T, np.zeros_like(covariance))
    frame = gain([block.moved_by_world(result) for block, result in each])
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


def _held_nests(campaign: Campaign, fit: RobustFit) -> dict[int, float]:
    """Return the standard uncertainty [mm] of each certified nest that is no parameter of the fit."""
    return {
        number: nest.standard_uncertainty_mm
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None
        and nest.standard_uncertainty_mm
        and not moves(number, fit.structure.names)
    }


def _nest_sensitivity(held: dict[int, float], block: Block, result: BlockResult) -> FloatArray:
    """Return how predictions move per standard uncertainty of each certified coordinate, (S, n, d)."""
    moved = [u_mm * block.moved_by_nest(result, number) for number, u_mm in held.items()]
    return np.concatenate([np.zeros((0, *result.residual.shape)), *moved])


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
