"""A sphere that a probe or gauge touches, and a point where a wire ends: distances from a centre.

With the nest at P, the centre at C and the distance z at which the instrument reads 0,

    reading = |P - C| - z

Source: thesis of A. Nubiola, 2014, sections 1.2 (a sphere as constraint) and 1.8 (CompuGauge, wires to the
tool; MasterCal, a probe and two spheres).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.targets import Target
from truepose.effects.ports import ParameterSpec
from truepose.identification.observations.contacts.against import PLACE_WIDTH_MM, Probe, Slope

# Readings that vary more than this are lengths of their own, which the distance can be told from.
_LONG_MM = 20.0


class Centre:
    """The centre of a sphere or of a wire's end; the zero too where it is not exact."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the coordinates of the centre in the world, and the distance that reads 0."""
        at = dict(zip(("x", "y", "z", "zero"), values.tolist(), strict=False))
        zero = target.zero_mm
        known = zero is not None
        told = {"zero": zero} if zero is not None else {}
        width = {"zero": target.zero_uncertainty_mm} if known else {}
        return tuple(
            ParameterSpec(name, "mm", told.get(name, start), width.get(name, PLACE_WIDTH_MM))
            for name, start in at.items()
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return the distances from the centre, less the zero."""
        return np.asarray(np.linalg.norm(probe.place_mm - values[:3], axis=1) - _zero(target, values))

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the directions away from the centre, and their opposites for the centre itself."""
        arm = probe.place_mm - values[:3]
        away = arm / np.linalg.norm(arm, axis=1)[:, None]
        own = -away.T if len(values) == 3 else np.vstack([-away.T, np.full(len(arm), -1.0)])
        return Slope(away, np.zeros_like(away), own)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the centre from equations that are linear in it once its own square is an unknown."""
        places = probe.place_mm
        if target.place_mm is not None:
            centre = np.array(target.place_mm)
        elif target.zero_mm is not None:
            centre = _trilaterated(places, reading_mm + target.zero_mm)
        elif np.std(reading_mm) > _LONG_MM:
            centre = _trilaterated(places, reading_mm, with_zero=True)
        else:
            centre = _trilaterated(places, np.zeros(len(places)))
        away = float(np.median(np.linalg.norm(places - centre, axis=1) - reading_mm))
        zero = away if target.zero_mm is None else target.zero_mm
        return target, np.append(centre, zero) if _has_zero(target) else centre

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it as it is: coordinates count from the world."""
        return target, values


def _has_zero(target: Target) -> bool:
    return target.zero_mm is None or target.zero_uncertainty_mm > 0.0


def _zero(target: Target, values: FloatArray) -> float:
    return float(values[3]) if len(values) > 3 else target.zero_mm or 0.0


def _trilaterated(places: FloatArray, length_mm: FloatArray, *, with_zero: bool = False) -> FloatArray:
    """Solve 2 P.C + 2 l z + (z^2 - |C|^2) = |P|^2 - l^2 for the centre; without zero, z = 0 in it."""
    middle = places.mean(axis=0)
    off = places - middle
    columns = [2.0 * off, np.ones((len(off), 1))]
    if with_zero:
        columns.append(2.0 * length_mm[:, None])
    right = (off**2).sum(axis=1) - length_mm**2
    return np.asarray(middle + np.linalg.lstsq(np.hstack(columns), right, rcond=1e-9)[0][:3])
