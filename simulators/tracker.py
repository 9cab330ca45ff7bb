"""The laser tracker as a device: where it stands, what it points at, how well it measures.

Noise per reading from the distance D [m], along the beam a + b D, across it c + d D; two-face error as a
collimation and an index error of the angles that change sign with the face. Line of sight is the
reflector's acceptance cone; that the arm itself might stand in the beam is not modelled.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from simulators.errors import BeamBrokenError, NoTargetError, ScenarioError
from simulators.physics.arm import Vector
from simulators.physics.rigid import FloatArray, inverse, motion, move, rotation


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
    initialise_s: float = 5.0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if name != "position_mm" and getattr(self, name) < 0.0:
                raise ScenarioError(f'key "{name}" must be 0 or more, not {getattr(self, name)}')


# The home reflector sits on the housing; tracker frame.
HOME_MM = (150.0, 0.0, -60.0)


@dataclass(frozen=True, slots=True)
class Target:
    """A reflector that may be there; a moving one is asked again whenever it is used."""

    name: str  # "tool 1", "fixed 2", "home"
    position_mm: FloatArray  # tracker frame, centre
    visible: bool


@dataclass(frozen=True, slots=True)
class PointMeasured:
    """One stationary measurement, tracker frame."""

    position_mm: FloatArray  # (3,)
    covariance_mm2: FloatArray  # (3, 3) of the position, as the samples show it
    apriori_covariance_mm2: FloatArray  # (3, 3) as the accuracy model states it
    samples: int


_SAMPLE_RATE_HZ = 50.0
_HOME_RADIUS_RAD = 0.01


def place_tracker(setup: TrackerSetup, rng: np.random.Generator) -> FloatArray:
    """Draw the tracker's frame in the world, shape (4, 4): any bearing, nearly plumb."""
    bearing = rng.uniform(-math.pi, math.pi)
    tilt = setup.tilt_rad * rng.standard_normal(2)
    offset = setup.position_u_mm * rng.standard_normal(3)
    upright = rotation(np.array([tilt[0], tilt[1], 0.0]))
    return motion(np.array(setup.position_mm) + offset, upright @ rotation(np.array([0.0, 0.0, bearing])))


class Tracker:
    """State of the head; knows no protocol and no unit but mm and rad."""

    def __init__(
        self,
        setup: TrackerSetup,
        frame: FloatArray,
        targets: Callable[[], Sequence[Target]],
        rng: np.random.Generator | None,
    ) -> None:
        """Stand at `frame` (4, 4); `targets` lists the cell's reflectors now; without `rng` no noise."""
        self.setup = setup
        self.frame = frame
        self.initialised = False
        self.face = 1
        self.aim_mm = np.array(HOME_MM)
        self.target: str | None = None
        self.last_measured_mm: FloatArray | None = None
        self._targets = targets
        self._rng = rng

    @property
    def tilt_rad(self) -> tuple[float, float]:
        """Tilt about the tracker's own x and y axes, as its level sees it."""
        plumb = self.frame[2, :3]  # the world's vertical in the tracker frame
        return float(math.asin(-plumb[1])), float(math.asin(plumb[0]))

    def initialise(self) -> None:
        """Find the encoders' zeros; ends in face 1 on the home reflector."""
        self.initialised = True
        self.face = 1
        self.go_home()

    def go_home(self) -> None:
        """Turn to the home reflector and lock on it, when it can be seen."""
        self.point(np.array(HOME_MM))
        self.search(_HOME_RADIUS_RAD)

    def point(self, aim_mm: FloatArray) -> None:
        """Turn the beam towards a point; nothing is locked on."""
        self.aim_mm = aim_mm
        self.target = None

    def search(self, radius_rad: float) -> bool:
        """Spiral around the aim; lock on the reflector nearest to the beam and say whether there is one."""
        self.target = None
        found = [(self._off_beam_rad(target), target) for target in self._targets() if target.visible]
        near = [(angle, target) for angle, target in found if angle <= radius_rad]
        if not near:
            return False
        target = min(near, key=lambda pair: pair[0])[1]
        self.target, self.aim_mm = target.name, target.position_mm
        return True

    def release(self) -> None:
        """Lose the reflector."""
        self.target = None

    def locked_target(self) -> Target:
        """Return the reflector locked on as it is now; raises NoTargetError or BeamBrokenError."""
        if self.target is None:
            raise NoTargetError("no reflector is locked on: search for one first")
        target = next((item for item in self._targets() if item.name == self.target), None)
        if target is None or not target.visible:
            self.target = None
            raise BeamBrokenError("the reflector no longer returns the beam")
        self.aim_mm = target.position_mm
        return target

    def measure(self, duration_s: float, before_mm: FloatArray | None = None) -> PointMeasured:
        """Measure the reflector locked on; raises NoTargetError or BeamBrokenError.

        Parameters
        ----------
        duration_s : float
            How long was averaged, up to now.
        before_mm : ndarray, shape (3,), optional
            Where the reflector was when the averaging began; it is smeared when it moved since.
        """
        now_mm = self.locked_target().position_mm
        travel = now_mm - (now_mm if before_mm is None else before_mm)
        true_mm = now_mm - travel / 2.0
        apriori = self.covariance_mm2(true_mm)
        smear = np.outer(travel, travel) / 12.0  # variance of an even motion over that way
        samples = max(1, round(duration_s * _SAMPLE_RATE_HZ))
        if self._rng is None:
            return PointMeasured(true_mm, apriori + smear, apriori, samples)
        noise = self._noise_mm(true_mm, self._rng.standard_normal(3))
        shown = self._rng.chisquare(samples - 1) / (samples - 1) if samples > 1 else 1.0
        measured = true_mm + self._face_error_mm(true_mm) + noise
        return PointMeasured(measured, apriori * shown + smear, apriori, samples)

    def covariance_mm2(self, position_mm: FloatArray) -> FloatArray:
        """Covariance that the accuracy model states for a reading there, tracker frame, shape (3, 3)."""
        beam, along, across = self._beam_and_deviations_mm(position_mm)
        projector = np.outer(beam, beam)
        covariance: FloatArray = along**2 * projector + across**2 * (np.eye(3) - projector)
        return covariance

    def _noise_mm(self, position_mm: FloatArray, unit: FloatArray) -> FloatArray:
        """Give three independent unit normals the covariance of a reading there."""
        beam, along, across = self._beam_and_deviations_mm(position_mm)
        on_beam = (beam @ unit) * beam
        noise: FloatArray = along * on_beam + across * (unit - on_beam)
        return noise

    def _beam_and_deviations_mm(self, position_mm: FloatArray) -> tuple[FloatArray, float, float]:
        """Direction of the beam, and standard deviations along and across it."""
        distance_mm = float(np.linalg.norm(position_mm))
        setup, distance_m = self.setup, distance_mm / 1000.0
        along = setup.along_mm + setup.along_mm_per_m * distance_m
        across = setup.across_mm + setup.across_mm_per_m * distance_m
        return position_mm / distance_mm, along, across

    def _off_beam_rad(self, target: Target) -> float:
        across = np.linalg.norm(np.cross(self.aim_mm, target.position_mm))
        return math.atan2(float(across), float(self.aim_mm @ target.position_mm))

    def _face_error_mm(self, position_mm: FloatArray) -> FloatArray:
        sign = 1.0 if self.face == 1 else -1.0
        sideways = np.array([-position_mm[1], position_mm[0], 0.0])
        sideways /= max(float(np.linalg.norm(sideways)), 1e-9)
        upwards = np.cross(position_mm, sideways)  # has the length of the distance
        distance = float(np.linalg.norm(position_mm))
        error: FloatArray = sign * self.setup.two_face_rad * (distance * sideways + upwards)
        return error


def seen_from(frame: FloatArray, position_mm: FloatArray) -> FloatArray:
    """World position in the tracker frame [mm]."""
    return move(inverse(frame), position_mm)


def returns_beam(
    frame: FloatArray, position_mm: FloatArray, facing: FloatArray, acceptance_rad: float
) -> bool:
    """Whether a reflector at a world position that faces `facing` (unit vector) sends the beam back."""
    towards = frame[:3, 3] - position_mm
    cosine = float(facing @ towards) / float(np.linalg.norm(towards))
    return cosine >= math.cos(acceptance_rad)
