"""Changes of place: so many mm and rad, at once or slowly; drawn where a scenario leaves them open.

`linear` goes on evenly (and came from before the origin of times); `exp<tau>` begins at the origin and dies
out with the time constant tau [s].
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray, inverse, pose_matrix, to_six

_LARGEST_ROTATION_RAD = 0.1
_S_PER_H = 3600.0

# How far something has come at times, (n,) -> (n, 6): `[tx ty tz rx ry rz]` [mm, rad].
Drift: TypeAlias = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True)
class _Way:
    """Which way a change goes; drawn where it is not stated."""

    direction: Vector | None = None  # of the translation, any length
    axis: Vector | None = None  # of the rotation, any length

    def __post_init__(self) -> None:
        _check_vector("direction", self.direction)
        _check_vector("axis", self.axis)


@dataclass(frozen=True, slots=True)
class JumpDetails(_Way):
    """Of a change at once."""

    rotation_rad: float = 0.0

    def __post_init__(self) -> None:
        _check_turn("rotation_rad", self.rotation_rad)
        _Way.__post_init__(self)


@dataclass(frozen=True, slots=True)
class DriftDetails(_Way):
    """Of a change that goes on."""

    rotation_rad_per_h: float = 0.0

    def __post_init__(self) -> None:
        _check_turn("rotation_rad_per_h", self.rotation_rad_per_h)
        _Way.__post_init__(self)


def planted_drift(change: effect.PlantedChange, site: effect.Site) -> Drift:
    """Return an even drift from the time of the change on, whose amplitude is in mm/h."""
    details = effect.read_details(DriftDetails, change)
    rate = _motion(change.amplitude, details.rotation_rad_per_h, details.direction, details.axis, site)
    per_s = rate / _S_PER_H

    def come(time_s: FloatArray) -> FloatArray:
        way: FloatArray = np.maximum(time_s - change.from_s, 0.0)[:, np.newaxis] * per_s
        return way

    return come


def jump(change: effect.PlantedChange, site: effect.Site) -> FloatArray:
    """Motion `[tx ty tz rx ry rz]` of a change at once whose amplitude is in mm, shape (6,)."""
    details = effect.read_details(JumpDetails, change)
    return _motion(change.amplitude, details.rotation_rad, details.direction, details.axis, site)


def unit_or_drawn(vector: Vector | None, rng: np.random.Generator) -> FloatArray:
    """Return the direction of a vector, or any direction at all where none is stated, shape (3,)."""
    # Drawn in any case: a direction that is stated leaves what is drawn after it as it was.
    drawn = rng.standard_normal(3)
    chosen = drawn if vector is None else np.array(vector)
    unit: FloatArray = chosen / np.linalg.norm(chosen)
    return unit


def _motion(
    translation: float, rotation: float, direction: Vector | None, axis: Vector | None, site: effect.Site
) -> FloatArray:
    rng = site.rng()
    along, about = unit_or_drawn(direction, rng), unit_or_drawn(axis, rng)
    return np.concatenate([translation * along, rotation * about])


def _check_turn(key: str, value: float) -> None:
    if abs(value) > _LARGEST_ROTATION_RAD:
        raise ScenarioError(f'key "{key}" must be within {_LARGEST_ROTATION_RAD:g} of 0, not {value:g}')


def _check_vector(key: str, value: Vector | None) -> None:
    if value is not None and not 1e-6 <= max(abs(part) for part in value) <= 1e6:
        raise ScenarioError(f'key "{key}" must be a vector with a direction, not {list(value)}')


def motion_in_world(frame: FloatArray, own: FloatArray) -> FloatArray:
    """Motions of a body, stated in its own frame as Trans RotX RotY RotZ, in the world about its origin.

    Parameters
    ----------
    frame : ndarray, shape (4, 4)
        The body in the world before it moves.
    own : ndarray, shape (..., 6)
        Shifts [mm] and the three angles [rad].

    Returns
    -------
    ndarray, shape (..., 6)
        `[tx ty tz rx ry rz]` [mm, rad] with a rotation vector, as `rigid.small_motion` takes it.
    """
    return to_six(frame @ pose_matrix(own[..., :3], own[..., 3:]) @ inverse(frame))


SHAPES = r"(linear|exp[0-9.e+]+)"


def identified_drift(rates: dict[str, FloatArray]) -> Drift:
    """Return what slow motions add up to, from their rates [mm/h, rad/h] by the names of their shapes."""

    def come(time_s: FloatArray) -> FloatArray:
        ways = [_hours(shape, time_s)[:, np.newaxis] * rate for shape, rate in rates.items()]
        way: FloatArray = np.sum(ways, axis=0)
        return way

    return come


def _hours(shape: str, time_s: FloatArray) -> FloatArray:
    """Return for how many hours a motion has gone on at its rate, at times since the origin."""
    if shape == "linear":
        return time_s / _S_PER_H
    # The rate dies out as exp(-t / tau); its integral from the origin is tau (1 - exp(-t / tau)).
    time_constant_s = float(shape.removeprefix("exp"))
    elapsed = np.maximum(time_s, 0.0) / time_constant_s
    return time_constant_s / _S_PER_H * (1.0 - np.exp(-elapsed))
