"""Waves of a joint's angle: their parameters by name, the orders that are looked for, and what was fitted.

A wave of order n turns its joint by

    s sin(n q) + c cos(n q) = A sin(n q + phase)        A = |(s, c)|, phase = atan2(c, s)

q the joint's own turn: n periods per turn of the joint.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail, Spectrum
from truepose.effects.causes import FittedCause, Scene, norm_beyond_noise, norm_with_uncertainty
from truepose.effects.ports import ParameterSpec
from truepose.messages.message import Message, message

ONE_PERIOD_FROM = 6.0  # periods per turn; a faster wave is drawn, and measured again, over one of them
_WIDTH_RAD = np.deg2rad(0.05)  # belief: few gears are off by more
# Of a robot that does not tell its gears no fast wave can be laid at their door: up to here bearings,
# encoders and the stages of common gears explain one.
_HIGHEST_OF_UNKNOWN_GEAR = 12
_OF_ITS_TURN = 2  # a ring that is out of centre, and one that is oval


def spectrum(fitted: FittedCause) -> Spectrum:
    """Return the amplitudes of fitted waves by their order.

    Parameters
    ----------
    fitted : FittedCause
        Sines and cosines of one joint [rad].
    """
    waves = fitted_waves(fitted)
    return Spectrum(
        np.array([wave.order for wave in waves]),
        np.array([wave.beyond_noise_deg for wave in waves]),
        np.array([wave.uncertainty_deg for wave in waves]),
    )


def orders(scene: Scene, joint: int) -> tuple[float, ...]:
    """Return the orders that are looked for on a joint (0-based): whole ones from 1.

    Up to twice the gear's ratio, once per turn of the motor being `ratio` periods per turn of the joint: a
    strain-wave gear has two waves per turn of its generator; no less than the two of the joint's own turn. Up
    to 12 where the ratio is unknown (docs/decisions/0015: among hundreds of orders some fast wave fits
    anything).
    """
    ratio = gear_ratio(scene, joint)
    # Whole orders only: a line between two of them is weighed afterwards, where a finer grid here would be
    # ten times as many chances for noise (docs/decisions/0030).
    highest = max(round(2.0 * ratio), _OF_ITS_TURN) if ratio else _HIGHEST_OF_UNKNOWN_GEAR
    return tuple(float(order) for order in range(1, highest + 1))


def is_whole(order: float) -> bool:
    """Whether a wave repeats with the turns of its joint."""
    return order == round(order)


def periods(order: float) -> Message:
    """Return e.g. `2 periods` per turn."""
    return message("periods.one" if order == 1.0 else "periods.several", order=spoken_order(order))


def spoken_order(order: float) -> str:
    """Return an order as people read it: a whole number, else with two decimals."""
    return f"{order:g}" if is_whole(order) else f"{order:.2f}"


def wave_names(joint: int, order: float) -> tuple[str, str]:
    """Return the names of the two parameters of a wave, e.g. `wave_3_2_sin` and `wave_3_2_cos`.

    Parameters
    ----------
    joint : int
        0-based.
    order : float
        With as many digits as a name has: `%g`.
    """
    # Six digits: terms are rebuilt from names alone, so that the order which counts is the one that the name
    # has.
    return f"wave_{joint + 1}_{order:g}_sin", f"wave_{joint + 1}_{order:g}_cos"


def joint_of_wave(name: str) -> int:
    """Return the joint, 0-based, that a parameter is of."""
    return int(name.split("_")[1]) - 1


def order_of_wave(name: str) -> float:
    """Return the order, periods per turn, that a parameter is of."""
    return float(name.split("_")[2])


def wave_specs(joint: int, order: float) -> tuple[ParameterSpec, ParameterSpec]:
    """Return sine and cosine of a wave [rad]; joint (0-based) and order as of `wave_names`."""
    sine, cosine = wave_names(joint, order)
    return ParameterSpec(sine, "rad", 0.0, _WIDTH_RAD), ParameterSpec(cosine, "rad", 0.0, _WIDTH_RAD)


class FittedWave:
    """A wave as it was fitted.

    Parameters
    ----------
    order : float
        Periods per turn.
    vector : ndarray, shape (2,)
        Sine and cosine [rad].
    covariance : ndarray, shape (2, 2)
    """

    def __init__(self, order: float, vector: FloatArray, covariance: FloatArray) -> None:
        self.order = order
        self.beyond_noise_deg = float(np.rad2deg(norm_beyond_noise(vector, covariance)))
        self.amplitude_deg, self.uncertainty_deg = np.rad2deg(
            norm_with_uncertainty(vector, covariance)
        ).tolist()
        self._phase_deg = float(np.rad2deg(np.arctan2(vector[1], vector[0])))

    def details(self, *, several: bool) -> list[Detail]:
        """Return order and phase [deg], and the amplitude where it is one of several.

        The phase is uncertain by atan(u / A), which ends at a quarter turn where the amplitude is nothing.
        """
        turn = float(np.rad2deg(np.arctan2(np.deg2rad(self.uncertainty_deg), np.deg2rad(self.amplitude_deg))))
        found = [Detail("order", self.order, "1", 0.0)]
        if several:
            found.append(Detail("amplitude", self.amplitude_deg, "deg", self.uncertainty_deg))
        return [*found, Detail("phase", self._phase_deg, "deg", turn)]


def fitted_waves(fitted: FittedCause) -> list[FittedWave]:
    """Return the waves that fitted parameters are of, by ascending order.

    Parameters
    ----------
    fitted : FittedCause
        Sine and cosine of each wave, of one joint.
    """
    found = []
    for order in sorted({order_of_wave(name) for name in fitted.names}):
        rows = [k for k, name in enumerate(fitted.names) if order_of_wave(name) == order]
        rows.sort(key=lambda k: fitted.names[k].endswith("_cos"))
        found.append(FittedWave(order, fitted.values[rows], fitted.covariance[np.ix_(rows, rows)]))
    return found


def gear_ratio(scene: Scene, joint: int) -> float:
    """Return turns of the motor per turn of a joint (0-based); 0 where the robot does not tell."""
    ratios = scene.setting.robot.gear_ratios
    return 0.0 if ratios is None else float(ratios[joint])
