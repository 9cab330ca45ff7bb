"""The tracker's place in the world from readings of certified nests, with its covariance. Pure.

With p_k the mean reading of nest k in the tracker's frame and c_k its certified centre, the rigid motion
x = R p + t minimises the weighted squares of `c_k - R p_k - t`. A small motion (dt, w) about the world
origin moves a point by `dt + w x x`, so J_k = [I, -(c_k x)], and with the weights W the covariance is
`A C A'`, A = (J'WJ)^-1 J'W, where C holds, nest by nest, certificate and reading.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.description import CertifiedLength
from truepose.domain.measurement.session import Registration
from truepose.domain.robot import FixedNest
from truepose.kinematics.frames import cross_matrix, rigid_alignment
from truepose.sequencing.tracker.world_frame.scale import Scale, scale_of_figure, scale_of_lengths

_ENOUGH_TO_SCATTER = 5  # readings, to speak of a scatter at all
_FAR_MORE = 2.0  # in variance: twenty readings show it by chance less than once in a million
_SMALLEST_UNCERTAINTY_MM = 1e-6  # keeps the weights of a noise-free cell finite


@dataclass(frozen=True, slots=True)
class NestMean:
    """Mean reading of one fixed nest in the tracker's frame."""

    point_mm: FloatArray  # (3,)
    covariance_mm2: FloatArray  # (3, 3) of the mean


def nest_mean(points_mm: FloatArray, stated_mm2: FloatArray) -> NestMean:
    """Mean of repeated readings and its covariance.

    The instrument's own statement holds, unless the readings scatter far more than it says.

    Parameters
    ----------
    points_mm : ndarray, shape (n, 3)
    stated_mm2 : ndarray, shape (n, 3, 3)
        What the instrument states of each reading [mm2]; NaN where it states nothing.
    """
    n = len(points_mm)
    stated = stated_mm2.mean(axis=0)
    if n < _ENOUGH_TO_SCATTER:
        return NestMean(points_mm.mean(axis=0), np.nan_to_num(stated) / n)
    scatter = np.cov(points_mm, rowvar=False)
    holds = float(np.trace(scatter)) <= _FAR_MORE * float(np.trace(stated))  # False for NaN
    return NestMean(points_mm.mean(axis=0), (stated if holds else scatter) / n)


def register(
    means: Sequence[NestMean],
    fixed_nests: Sequence[FixedNest],
    *,
    two_face_mm: float | None = None,
    lengths: Sequence[CertifiedLength] = (),
) -> Registration:
    """Place the tracker in the world.

    Parameters
    ----------
    means : sequence of NestMean
        One per fixed nest, in the order of `fixed_nests`; at least three, not on a line.
    fixed_nests : sequence of FixedNest
    two_face_mm : float, optional
        Half the difference between the faces, only passed on.
    lengths : sequence of CertifiedLength, optional
        Certified by themselves: they say more of the scale than the centres do.
    """
    measured = np.array([mean.point_mm for mean in means])
    certified = np.array([nest.centre_mm for nest in fixed_nests])
    readings, certificates = _reading_covariances(means), _certificate_covariances(fixed_nests)
    weights = 3.0 / np.trace(readings + certificates, axis1=1, axis2=2)
    rotation, translation = rigid_alignment(measured, certified, weights)
    residuals = certified - measured @ rotation.T - translation
    turned = rotation @ readings @ rotation.T
    scale = _scale(measured @ rotation.T, certified, turned, certificates, lengths)
    return Registration(
        rotation=rotation,
        translation_mm=translation,
        covariance=_covariance_of_motion(certified, turned + certificates, weights),
        rms_mm=float(np.sqrt(np.mean(np.sum(residuals**2, axis=1)))),
        two_face_mm=two_face_mm,
        scale=scale.value if scale.verified else None,
        scale_standard_uncertainty=scale.standard_uncertainty if scale.verified else None,
    )


def _reading_covariances(means: Sequence[NestMean]) -> FloatArray:
    return np.array([mean.covariance_mm2 for mean in means])


def _certificate_covariances(fixed_nests: Sequence[FixedNest]) -> FloatArray:
    u_mm = np.array([nest.standard_uncertainty_mm for nest in fixed_nests])
    covariances: FloatArray = np.maximum(u_mm, _SMALLEST_UNCERTAINTY_MM)[:, None, None] ** 2 * np.eye(3)
    return covariances


def _covariance_of_motion(certified: FloatArray, covariances: FloatArray, weights: FloatArray) -> FloatArray:
    jacobian = np.concatenate(
        [np.broadcast_to(np.eye(3), (len(certified), 3, 3)), -cross_matrix(certified)], axis=2
    )
    normal = np.einsum("n,nki,nkj->ij", weights, jacobian, jacobian)
    gain = np.linalg.solve(normal, np.einsum("n,nki->ink", weights, jacobian).reshape(6, -1))
    gain = gain.reshape(6, -1, 3)
    covariance: FloatArray = np.einsum("ink,nkl,jnl->ij", gain, covariances, gain)
    return covariance


def _scale(
    turned: FloatArray,
    certified: FloatArray,
    readings: FloatArray,
    certificates: FloatArray,
    lengths: Sequence[CertifiedLength],
) -> Scale:
    if lengths:
        return scale_of_lengths(turned, readings, lengths)
    return scale_of_figure(turned, certified, readings + certificates)


def to_world(registration: Registration, point_mm: FloatArray) -> FloatArray:
    """Return points of the tracker's frame in the world, shape (..., 3)."""
    result: FloatArray = point_mm @ registration.rotation.T + registration.translation_mm
    return result


def to_tracker(registration: Registration, point_mm: FloatArray) -> FloatArray:
    """Return points of the world in the tracker's frame, shape (..., 3)."""
    result: FloatArray = (point_mm - registration.translation_mm) @ registration.rotation
    return result
