"""Ballbar zero: what a ballbar reads too much since it was set on its calibrator, constant or growing.

    a length reads too much by  zero_m                    or  zerorate_m (t - t_m)

after initialisation m, until the next one. `zero_<initialisation>` is a constant;
`zerorate_<initialisation>_<time>` grows from nothing at that time t_m [s], that of the first reading after
the initialisation (magnetic snaps, handling). Initialisations are numbered anew in each session: of a made
model, neither is there before its first reading or after its last one.

Source of its size: thesis of A. Nubiola, 2014, sections 3.2 and 3.5 (up to 3 um between initialisations).
"""

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.motions import SECONDS_PER_HOUR, hours_since
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "ballbar_zero"
_CONSTANT, _GROWING = "zero", "zerorate"
_WIDTH_MM = 0.03  # ten times the walk of a good ballbar
_WIDTH_MM_PER_H = 0.5  # the same in the few minutes between two initialisations
_ROUNDING_S = 1e-3  # of stored times


class BallbarZero:
    """One constant, or one drift rate, per initialisation."""

    name = NAME
    needs: frozenset[Need] = frozenset({"initialisation"})
    traits = frozenset({Trait.OF_LENGTHS})
    signature = Signature("ballbar", "constant", "group", "constant length error")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return one constant per initialisation."""
        return _constants(setting)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Lengthen what is read after each initialisation: weight 1, or the hours since its first reading."""
        return [Term(k, Port(PortKind.LENGTH, 0), _weight(name, rows)) for k, name in enumerate(names)]

    def unseen(self, scene: Scene) -> Text | None:
        """Need lengths whose initialisations are known, and more than one where the length has an offset."""
        if not scene.legs:
            return message("unseen.no_lengths")
        known = len(scene.setting.initialisations)
        if known == 0:
            return message("unseen.initialisations_not_numbered")
        # A wire of unknown length has an offset already; one zero of all its lengths does the same.
        if known == 1 and "length_offset" in scene.present:
            return message("unseen.one_initialisation")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose constants, and rates where times are known within initialisations."""
        if self.unseen(scene):
            return ()
        proposed = (
            # All initialisations together: each zero is a draw of its own, and what is looked for is how far
            # they scatter.
            Candidate(NAME, "ballbar", _constants(scene.setting)),
            Candidate(NAME, "ballbar", _rates(scene), 1.0),
        )
        return tuple(
            candidate for candidate in proposed if candidate.specs and candidate.names[0] not in scene.present
        )

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say what the ballbar reads too much, root mean square over the initialisations."""
        errors, covariance = _at_the_end(fitted, scene)
        amplitude, uncertainty = _root_mean_square(errors, covariance)
        growing = any(name.startswith(_GROWING) for name in fitted.names)
        key = "causes.ballbar_zero.growing" if growing else "causes.ballbar_zero.constant"
        sentence = message(key, amplitude_um=1e3 * amplitude, initialisations=len(errors))
        details = (
            Detail("mean", float(errors.mean()), "mm", float(np.sqrt(covariance.mean()))),
            Detail("initialisations", float(len(errors)), "1", 0.0),
        )
        return Description(subject, amplitude, "mm", uncertainty, sentence, details)


def _constants(setting: Setting) -> tuple[ParameterSpec, ...]:
    return tuple(
        ParameterSpec(f"{_CONSTANT}_{number}", "mm", 0.0, _WIDTH_MM) for number in setting.initialisations
    )


def _rates(scene: Scene) -> tuple[ParameterSpec, ...]:
    """Propose a rate for each initialisation that was followed by readings at more than one time."""
    spans = {number: _span_s(scene, number) for number in scene.setting.initialisations}
    return tuple(
        ParameterSpec(f"{_GROWING}_{number}_{first_s:.3f}", "mm/h", 0.0, _WIDTH_MM_PER_H)
        for number, (first_s, last_s) in spans.items()
        if last_s > first_s
    )


def _span_s(scene: Scene, number: int) -> tuple[float, float]:
    """Return the times of the first and last reading after an initialisation, zeros where unknown."""
    time_s, initialisation = scene.stops.time_s, scene.initialisation
    if time_s is None or initialisation is None:
        return 0.0, 0.0
    known = time_s[(initialisation == number) & np.isfinite(time_s)]
    return (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)


def _weight(name: str, rows: Rows) -> FloatArray:
    """Return the weight (n,) of one parameter: 0 for rows of other initialisations."""
    kind, number, *start_s = name.split("_")
    here = _after(int(number), rows)
    if kind == _CONSTANT:
        return here.astype(float)
    # Of a made model a row without a time is at infinity: an error that is over with the next initialisation
    # has not grown until then.
    return np.where(here, np.nan_to_num(hours_since(rows, float(start_s[0])), posinf=0.0), 0.0)


def _after(number: int, rows: Rows) -> BoolArray:
    """Say which rows were read after an initialisation, shape (n,); of a made model, of its own sessions."""
    if rows.initialisation is None:
        return np.zeros(len(rows.stops), dtype=bool)
    here = np.asarray(rows.initialisation == number)
    time_s = rows.stops.time_s
    if time_s is None or rows.last_s is None:
        return here
    # Of a row without a time its number is all that is known.
    elsewhere = (time_s < rows.origin_s - _ROUNDING_S) | (time_s > rows.last_s + _ROUNDING_S)
    return here & ~elsewhere


def _at_the_end(fitted: FittedCause, scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the error before the next initialisation, shape (M,) [mm], and its covariance (M, M).

    A constant counts as it is, a rate by the hours from the first to the last reading.
    """
    numbers = sorted({int(name.split("_")[1]) for name in fitted.names})
    gather = np.zeros((len(numbers), len(fitted.names)))
    for k, name in enumerate(fitted.names):
        kind, number, *_ = name.split("_")
        first_s, last_s = _span_s(scene, int(number))
        gather[numbers.index(int(number)), k] = (
            1.0 if kind == _CONSTANT else (last_s - first_s) / SECONDS_PER_HOUR
        )
    return gather @ fitted.values, gather @ fitted.covariance @ gather.T


def _root_mean_square(errors: FloatArray, covariance: FloatArray) -> tuple[float, float]:
    """Root mean square less what noise adds to it, and its standard uncertainty.

    With few initialisations the next ones may differ: the scatter of a root mean square of M normal
    numbers, 1 / sqrt(2 M) of it, is part of the uncertainty.

    With e the errors and C their covariance: rms^2 = (e.e - tr C) / M, no less than d^T C d with d = e / (M
    |rms|) the derivative; variance d^T C d + rms^2 / (2 M).

    Parameters
    ----------
    errors : ndarray, shape (M,)
        [mm]
    covariance : ndarray, shape (M, M)

    Returns
    -------
    rms, standard_uncertainty : float
        [mm]
    """
    count = len(errors)
    square = float(errors @ errors) / count
    if square == 0.0:
        return 0.0, float(np.sqrt(np.trace(covariance) / count))
    direction = errors / (count * np.sqrt(square))
    noise = float(direction @ covariance @ direction)
    root = float(np.sqrt(max(square - float(np.trace(covariance)) / count, noise)))
    return root, float(np.sqrt(noise + root**2 / (2.0 * count)))
