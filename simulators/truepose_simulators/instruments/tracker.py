"""The laser tracker as a device: where it stands, what it points at, how well it measures.

Two-face error is a collimation and an index error of the angles that change sign with the face. Line of
sight is the reflector's acceptance cone; that the arm itself might stand in the beam is not modelled.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from truepose_simulators.errors import BeamBrokenError, NoTargetError
from truepose_simulators.instruments.accuracy import (
    TrackerSetup,
    covariance_mm2,
    face_error_mm,
    noise_mm,
)
from truepose_simulators.physics.rigid import FloatArray, inverse, motion, move, rotation

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
        frame: Callable[[], FloatArray],
        targets: Callable[[], Sequence[Target]],
        rng: np.random.Generator | None,
        spoil: Callable[[str, FloatArray], FloatArray],
    ) -> None:
        """Stand at `frame` (4, 4) in the world now; without `rng` no noise.

        `targets` lists the cell's reflectors now; `spoil` says what becomes of a reading of one of them.
        """
        self.setup = setup
        self.initialised = False
        self.face = 1
        self.aim_mm = np.array(HOME_MM)
        self.target: str | None = None
        self.last_measured_mm: FloatArray | None = None
        self._frame = frame
        self._targets = targets
        self._rng = rng
        self._spoil = spoil

    @property
    def frame(self) -> FloatArray:
        """Where the tracker stands in the world now, shape (4, 4)."""
        return self._frame()

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
        target = self.locked_target()
        now_mm = target.position_mm
        travel = now_mm - (now_mm if before_mm is None else before_mm)
        true_mm = now_mm - travel / 2.0
        apriori = self.covariance_mm2(true_mm)
        smear = np.outer(travel, travel) / 12.0  # variance of an even motion over that way
        samples = max(1, round(duration_s * _SAMPLE_RATE_HZ))
        if self._rng is None:
            return PointMeasured(self._spoil(target.name, true_mm), apriori + smear, apriori, samples)
        noise = noise_mm(self.setup, true_mm, self._rng)
        # A variance estimated from n samples scatters about the true one like chi-squared of n - 1 over n -
        # 1.
        shown = self._rng.chisquare(samples - 1) / (samples - 1) if samples > 1 else 1.0
        measured = true_mm + face_error_mm(self.setup, true_mm, self.face) + noise
        return PointMeasured(self._spoil(target.name, measured), apriori * shown + smear, apriori, samples)

    def covariance_mm2(self, position_mm: FloatArray) -> FloatArray:
        """Covariance that the accuracy model states for a reading there, tracker frame, shape (3, 3)."""
        return covariance_mm2(self.setup, position_mm)

    def _off_beam_rad(self, target: Target) -> float:
        across = np.linalg.norm(np.cross(self.aim_mm, target.position_mm))
        return math.atan2(float(across), float(self.aim_mm @ target.position_mm))


def in_tracker_frame(frame: FloatArray, position_mm: FloatArray) -> FloatArray:
    """World position in the tracker frame [mm]."""
    return move(inverse(frame), position_mm)


def returns_beam(
    frame: FloatArray, position_mm: FloatArray, facing: FloatArray, acceptance_rad: float
) -> npt.NDArray[np.bool_]:
    """Whether reflectors at world positions (..., 3) that face `facing` (unit vectors) send the beam back."""
    return np.asarray(cosine_to_beam(frame, position_mm, facing) >= math.cos(acceptance_rad))


def cosine_to_beam(frame: FloatArray, position_mm: FloatArray, facing: FloatArray) -> FloatArray:
    """How well reflectors at world positions (..., 3) face the tracker, 1 at best; shape (...)."""
    towards = frame[..., :3, 3] - position_mm
    cosine: FloatArray = np.sum(facing * towards, axis=-1) / np.linalg.norm(towards, axis=-1)
    return cosine
