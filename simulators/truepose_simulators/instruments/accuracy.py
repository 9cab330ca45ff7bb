"""How well tracker, camera and ballbar measure: their setups, their noise, their systematic errors.

The standard deviation of a reading depends on the distance D [m], along the beam a + b D, across it c + d D.

Source of the sizes: A. Nubiola, thesis, ETS Montreal 2014, sections 3.2 (2 um at 95 %) and 3.5 (the magnets'
snaps and handling add up to 3 um between two initialisations).
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.table import require_above_0, require_at_least_0


@dataclass(frozen=True, slots=True)
class TrackerSetup:
    """Where the tracker stands and how good it is."""

    position_mm: Vector = (2600.0, -700.0, 500.0)  # world
    position_u_mm: float = 5.0  # the tripod stands about there, one sigma per axis
    tilt_rad: float = 0.002  # out of plumb, one sigma about both horizontal axes
    along_mm: float = 0.008
    along_mm_per_m: float = 0.0008
    across_mm: float = 0.010
    across_mm_per_m: float = 0.0035
    two_face_rad: float = 0.5e-6  # collimation and index error
    noise_degrees_of_freedom: float | None = None  # of Student's t; absent: normal
    initialise_s: float = 5.0

    def __post_init__(self) -> None:
        sizes = (name for name in self.__dataclass_fields__ if isinstance(getattr(self, name), float | int))
        require_at_least_0(self, *sizes)
        freedom = self.noise_degrees_of_freedom
        if freedom is not None and freedom <= 2.0:  # no finite variance to scale to what is stated
            raise ScenarioError(f'key "noise_degrees_of_freedom" must be above 2, not {freedom}')


@dataclass(frozen=True, slots=True)
class ProbeSetup:
    """A probe of six degrees of freedom on the flange, in the frame of the tool's nests."""

    rotation_rad: float = 6e-5  # noise of one reading about each axis
    facing: Vector = (0.0, 0.0, 1.0)  # flange frame
    acceptance_deg: float = 180.0  # between facing and line of sight; 180: lamps on all sides
    reach_mm: float = 9000.0  # of the camera on the tracker

    def __post_init__(self) -> None:
        require_at_least_0(self, "rotation_rad")
        require_above_0(self, "acceptance_deg", "reach_mm")
        if not any(self.facing):
            raise ScenarioError('key "facing" must not be a zero vector')


def covariance_mm2(setup: TrackerSetup, position_mm: FloatArray) -> FloatArray:
    """Covariance that the accuracy model states for readings, tracker frame, (..., 3) -> (..., 3, 3).

    With u the direction of the beam and s the standard deviations: s_along^2 u u' + s_across^2 (1 - u u').
    """
    beam, along, across = _beam_and_deviations_mm(setup, position_mm)
    projector = beam[..., :, np.newaxis] * beam[..., np.newaxis, :]
    off_beam = across[..., np.newaxis] ** 2 * (np.eye(3) - projector)
    covariance: FloatArray = along[..., np.newaxis] ** 2 * projector + off_beam
    return covariance


def noise_mm(setup: TrackerSetup, position_mm: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Draw noise of one reading per point, tracker frame, shape (..., 3)."""
    unit = _unit_noise(setup, position_mm.shape, rng)
    beam, along, across = _beam_and_deviations_mm(setup, position_mm)
    on_beam = np.sum(beam * unit, axis=-1, keepdims=True) * beam
    noise: FloatArray = along * on_beam + across * (unit - on_beam)
    return noise


def face_error_mm(setup: TrackerSetup, position_mm: FloatArray, face: int) -> FloatArray:
    """Error that changes its sign with the face (1 or 2), tracker frame, shape (..., 3)."""
    sign = 1.0 if face == 1 else -1.0
    x, y, _ = np.moveaxis(position_mm, -1, 0)
    sideways = np.stack([-y, x, np.zeros_like(x)], axis=-1)
    sideways /= np.maximum(np.linalg.norm(sideways, axis=-1, keepdims=True), 1e-9)
    upwards = np.cross(position_mm, sideways)  # has the length of the distance
    distance = np.linalg.norm(position_mm, axis=-1, keepdims=True)
    error: FloatArray = sign * setup.two_face_rad * (distance * sideways + upwards)
    return error


def _unit_noise(setup: TrackerSetup, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    """Draw numbers of variance 1, normal or with Student's heavier tails."""
    freedom = setup.noise_degrees_of_freedom
    if freedom is None:
        return rng.standard_normal(shape)
    # Student's t has the variance f / (f - 2); scaled, its tails alone differ from the normal ones.
    scaled: FloatArray = rng.standard_t(freedom, shape) * np.sqrt((freedom - 2.0) / freedom)
    return scaled


def _beam_and_deviations_mm(
    setup: TrackerSetup, position_mm: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Direction of the beam (..., 3), and standard deviations along and across it, each (..., 1)."""
    distance_mm = np.linalg.norm(position_mm, axis=-1, keepdims=True)
    along: FloatArray = setup.along_mm + setup.along_mm_per_m * distance_mm / 1000.0
    across: FloatArray = setup.across_mm + setup.across_mm_per_m * distance_mm / 1000.0
    return position_mm / distance_mm, along, across


@dataclass(frozen=True, slots=True)
class CameraSetup:
    """Where the camera stands, how good it is, and how the artefact must be turned to be seen."""

    position_mm: Vector = (2200.0, 0.0, 900.0)  # world
    looks_at_mm: Vector = (0.0, 0.0, 0.0)
    position_u_mm: float = 5.0  # the stand is about there, one sigma per axis
    tilt_rad: float = 0.002
    reach_mm: float = 3000.0  # of the measuring volume
    nest_mm: float = 0.045  # of each nest's coordinates, the same as long as the arm stands
    frame_mm: float = 0.010  # of one frame besides
    artefact_mm: float = 0.040  # by which the artefact's definition is off in each nest's coordinates, always
    acceptance_deg: float = 15.0  # between normal and line of sight; 180: markers on all sides
    frame_hz: float = 60.0

    def __post_init__(self) -> None:
        require_at_least_0(self, "position_u_mm", "tilt_rad", "nest_mm", "frame_mm", "artefact_mm")
        require_above_0(self, "reach_mm", "acceptance_deg", "frame_hz")
        if self.position_mm[:2] == self.looks_at_mm[:2]:
            raise ScenarioError(
                'keys "position_mm" and "looks_at_mm" must not be vertically above each other'
            )


@dataclass(frozen=True, slots=True)
class BallbarSetup:
    """The ballbar and how its cups come to their places."""

    nominal_mm: float = 300.0  # with the bars for base triangle and legs
    tool_nominal_mm: float = 150.0  # with the bars for the tool triangle
    # No side of a fixture is made to the calibrator's length, or nobody could tell them apart.
    calibrator_excess_mm: float = 0.04  # by which the calibrator is longer than nominal
    range_mm: float = 1.0  # either way of the nominal length
    resolution_mm: float = 0.0001
    noise_mm: float = 0.00051  # of one reading
    snap_mm: float = 0.0006  # by which the zero walks whenever a magnet takes or lets go of a ball
    zero_bound_mm: float = 0.003  # no farther from the zero of the last initialisation
    clamp_mm: float = 0.01  # per axis, between the ball that the robot held and the clamped cup
    bars_mm: float = 0.02  # by which bars are off their nominal length each time they are screwed on
    travel_mm: float = 3.0  # either way, before a magnet lets go

    def __post_init__(self) -> None:
        require_at_least_0(self, *self.__dataclass_fields__)
        if min(self.range_mm, self.resolution_mm) <= 0.0:
            raise ScenarioError('keys "range_mm" and "resolution_mm" must be above 0')

    @property
    def stated_u_mm(self) -> float:
        """Standard uncertainty of a reading: noise, and a zero that is somewhere between its bounds."""
        return float(np.hypot(self.noise_mm, self.zero_bound_mm / 2.0))


def snapped_zero_mm(setup: BallbarSetup, zero_mm: float, rng: np.random.Generator) -> float:
    """Return the zero after one more snap; at its bounds it stops."""
    walked = zero_mm + setup.snap_mm * float(rng.standard_normal())
    return float(np.clip(walked, -setup.zero_bound_mm, setup.zero_bound_mm))


def walked_zeros_mm(setup: BallbarSetup, n: int, rng: np.random.Generator) -> FloatArray:
    """Zeros of `n` readings after one initialisation, the ballbar taken off and put on before each."""
    zeros, zero_mm = np.zeros(n), 0.0
    for reading in range(n):
        for _ in range(_SNAPS_PER_READING):
            zero_mm = snapped_zero_mm(setup, zero_mm, rng)
        zeros[reading] = zero_mm
    return zeros


# Both ends leave one pair of balls and come to another.
_SNAPS_PER_READING = 2


def rounded_mm(setup: BallbarSetup, length_mm: FloatArray) -> FloatArray:
    """Lengths as the display has them."""
    shown: FloatArray = np.round(length_mm / setup.resolution_mm) * setup.resolution_mm
    return shown
