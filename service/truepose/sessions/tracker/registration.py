"""The tracker's place in the world from readings of certified nests, and its scale. Pure.

Lengths certified by themselves come first; where there are none, the figure of the fixed nests' certified
centres is as good as one, as long as its certificate is fine enough to say something.

With p_k the mean reading of nest k in the tracker's frame and c_k its certified centre, the rigid motion
x = R p + t minimises the weighted squares of `c_k - R p_k - t`. A small motion (dt, w) about the world
origin moves a point by `dt + w x x`, so J_k = [I, -(c_k x)], and with the weights W the covariance is
`A C A'`, A = (J'WJ)^-1 J'W, where C holds, nest by nest, certificate and reading.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import CertifiedLength
from truepose.domain.robot import FixedNest
from truepose.domain.session import Registration
from truepose.kinematics.frames import cross_matrix, rigid_alignment
from truepose.messages.message import Message, message
from truepose.sessions.errors import AttentionNeededError

VERIFIED_BELOW: Final = 5e-5  # standard uncertainty; 0.05 mm at 1 m would spoil every absolute figure


@dataclass(frozen=True, slots=True)
class Scale:
    """Certified over measured length [1]."""

    value: float
    standard_uncertainty: float

    @property
    def verified(self) -> bool:
        """Whether the certificate is fine enough to speak of the scale at all."""
        return self.standard_uncertainty < VERIFIED_BELOW


def scale_of_figure(measured_mm: FloatArray, certified_mm: FloatArray, covariances_mm2: FloatArray) -> Scale:
    """Scale from the size of a figure of points, turned alike (Umeyama 1991, equation 42).

    With m_k the measured and a_k the certified points, each less its centroid, and C_k the covariance of
    their difference: scale = sum a_k . m_k / sum |m_k|^2, variance = sum a_k' C_k a_k / (sum |m_k|^2)^2.

    Parameters
    ----------
    measured_mm, certified_mm : ndarray, shape (n, 3)
    covariances_mm2 : ndarray, shape (n, 3, 3)
        Of the differences between the two, certificate included.
    """
    measured = measured_mm - measured_mm.mean(axis=0)
    arms = certified_mm - certified_mm.mean(axis=0)
    size = float(np.sum(measured**2))
    variance = float(np.einsum("ni,nij,nj->", arms, covariances_mm2, arms)) / size**2
    return Scale(float(np.sum(arms * measured)) / size, float(np.sqrt(variance)))


def scale_of_lengths(
    measured_mm: FloatArray, covariances_mm2: FloatArray, lengths: Sequence[CertifiedLength]
) -> Scale:
    """Scale from certified lengths between nests, the nests that they share taken into account.

    With r_a the certified over the measured length a, and V the relative covariance of these ratios, the
    generalised least-squares mean is (1' V^-1 r) / (1' V^-1 1), with the variance 1 / (1' V^-1 1).

    Parameters
    ----------
    measured_mm : ndarray, shape (n, 3)
    covariances_mm2 : ndarray, shape (n, 3, 3)
        Of the readings alone.
    lengths : sequence of CertifiedLength
        At least one; their nests are 1-based rows of `measured_mm`.
    """
    ends = np.array([length.fixed_nests for length in lengths]) - 1
    arms = measured_mm[ends[:, 1]] - measured_mm[ends[:, 0]]
    long_mm = np.linalg.norm(arms, axis=1)
    gradient = np.zeros((len(lengths), *measured_mm.shape))
    rows = np.arange(len(lengths))
    gradient[rows, ends[:, 1]] = arms / long_mm[:, None]
    gradient[rows, ends[:, 0]] = -arms / long_mm[:, None]
    covariance = np.einsum("ani,nij,bnj->ab", gradient, covariances_mm2, gradient)
    covariance += np.diag([length.standard_uncertainty_mm**2 for length in lengths])
    relative = covariance / np.outer(long_mm, long_mm)
    weights = np.linalg.solve(relative, np.ones(len(lengths)))
    ratios = np.array([length.length_mm for length in lengths]) / long_mm
    return Scale(float(weights @ ratios / weights.sum()), float(weights.sum() ** -0.5))


def scale_sentence(registration: Registration) -> Message:
    """Say what the certified lengths say of the tracker's scale."""
    if registration.scale is None or registration.scale_standard_uncertainty is None:
        return message("session.scale.none")
    off, u = 1e6 * (registration.scale - 1.0), 1e6 * registration.scale_standard_uncertainty
    verdict = "session.scale.agrees" if abs(off) <= 3.0 * u else "session.scale.contradicts"
    return message(verdict, off_ppm=off, u_ppm=u)


_ENOUGH_TO_CONTRADICT = 5  # readings, for their scatter to speak against what is stated
_FEWEST_THAT_SCATTER = 2
_FAR_MORE = 2.0  # in variance: twenty readings show it by chance less than once in a million
_SMALLEST_UNCERTAINTY_MM = 1e-6  # keeps the weights of a noise-free cell finite


@dataclass(frozen=True, slots=True)
class NestMean:
    """Mean reading of one fixed nest in the tracker's frame."""

    point_mm: FloatArray  # (3,)
    covariance_mm2: FloatArray  # (3, 3) of the mean


def nest_mean(points_mm: FloatArray, stated_mm2: FloatArray) -> NestMean:
    """Mean of repeated readings and its covariance.

    The instrument's own statement holds, unless five readings or more scatter far more than it says. Where it
    states nothing their scatter speaks: S / n, with S the covariance of the n readings.

    Parameters
    ----------
    points_mm : ndarray, shape (n, 3)
    stated_mm2 : ndarray, shape (n, 3, 3)
        What the instrument states of each reading [mm2]; NaN where it states nothing.

    Raises
    ------
    AttentionNeededError
        One reading, of which nothing is stated: nobody knows how good it is.
    """
    n, mean = len(points_mm), points_mm.mean(axis=0)
    stated = stated_mm2.mean(axis=0)
    is_stated = bool(np.all(np.isfinite(stated)))
    if is_stated and n < _ENOUGH_TO_CONTRADICT:
        return NestMean(mean, stated / n)
    if n < _FEWEST_THAT_SCATTER:
        raise AttentionNeededError(message("session.nests.no_uncertainty"))
    scatter = np.cov(points_mm, rowvar=False)
    holds = is_stated and float(np.trace(scatter)) <= _FAR_MORE * float(np.trace(stated))
    return NestMean(mean, (stated if holds else scatter) / n)


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
    # One weight a nest, for its mean variance along an axis: the alignment in closed form knows no other.
    # That readings are worse along the beam is in the covariance again.
    weights = 3.0 / np.trace(readings + certificates, axis1=1, axis2=2)
    rotation, translation = rigid_alignment(measured, certified, weights)
    residuals = certified - measured @ rotation.T - translation
    # Certificates are stated in the world, readings in the tracker's frame.
    turned = rotation @ readings @ rotation.T
    scale = _scale(measured @ rotation.T, certified, turned, certificates, lengths)
    return Registration(
        rotation=rotation,
        translation_mm=translation,
        covariance=_covariance_of_motion(certified, turned + certificates, weights),
        rms_mm=float(np.sqrt(np.mean(np.sum(residuals**2, axis=1)))),
        two_face_mm=two_face_mm,
        # A coarse certificate would put a scale into words of which nothing is known (limit: 5e-5).
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


@dataclass(frozen=True, slots=True)
class RoughFrame:
    """The tracker's frame in the world, good enough to aim: x_world = R x_tracker + t."""

    rotation: FloatArray  # (3, 3)
    translation_mm: FloatArray  # (3,)


def to_world(frame: Registration | RoughFrame, point_mm: FloatArray) -> FloatArray:
    """Return points of the tracker's frame in the world, shape (..., 3)."""
    result: FloatArray = point_mm @ frame.rotation.T + frame.translation_mm
    return result


def to_tracker(frame: Registration | RoughFrame, point_mm: FloatArray) -> FloatArray:
    """Return points of the world in the tracker's frame, shape (..., 3)."""
    result: FloatArray = (point_mm - frame.translation_mm) @ frame.rotation
    return result
