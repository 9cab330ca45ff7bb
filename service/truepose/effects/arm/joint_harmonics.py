"""Joint harmonics: a joint is off by waves of its own angle (gear, bearing, encoder).

    theta_i moves by  sum over orders of s sin(order q_i) + c cos(order q_i)

q the joint's own turn. Orders are searched from one wave per turn up to twice the gear's own cycle: a
strain-wave gear has two waves per turn of its generator. Those that are looked for are whole; one that was
found may lie between them, as the stages of a gear do (docs/decisions/0030).

Besides single waves a joint may have a curve: all orders up to 60 as one random function. Joints of real
robots are off by dozens of lines without a gear ratio, which told wave by wave were explained badly.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Stops
from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    OfTurningJoints,
    Scene,
    Signature,
)
from truepose.effects.names import joint_of_subject, joint_subject
from truepose.effects.ports import ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.effects.waves import (
    FittedWave,
    fitted_waves,
    gear_ratio,
    is_whole,
    joint_of_wave,
    order_of_wave,
    orders,
    periods,
    spoken_order,
    wave_specs,
)
from truepose.messages.message import Message, message

NAME = "joint_harmonics"
# An IRB 120 with such curves, 1,000 readings: a held-out RMS of 0.231 mm by single waves, of 0.090 mm by the
# curve, where the noise of these readings is 0.089.
_HIGHEST_OF_CURVE = 60.0  # per turn, of curves that no few waves describe
_FEW_WAVES = 24  # that are told as waves; more are a curve
_SHARE_OF_ORDERS = 0.5  # of all up to the highest, from which it pays to work out every one
_TOLD = 5  # waves of a curve that are told, the largest ones
_ANGLES = 2000  # at which a curve is looked at: dozens a period of its highest order


class JointHarmonics(OfTurningJoints):
    """Harmonics of any order on any joint."""

    name = NAME
    traits = frozenset({Trait.STEADY, Trait.WAVES, Trait.AGEING})
    signature = Signature(
        OF_SUBJECT,
        "angle of {subject}",
        "wave",
        "half the peak-to-peak value",
        function="curve",
        drawn="joint",
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return orders 1 and 2 of every joint, for whoever names the effect; a search tries more."""
        return tuple(
            spec
            for joint in range(setting.robot.n_joints)
            for order in (1.0, 2.0)
            for spec in wave_specs(joint, order)
        )

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the joint by its waves: weight sin(order q) or cos(order q) on its theta."""
        if not names:
            return []
        table = _table(names)
        found = []
        for joint in distinct_values(table.joint).tolist():
            # Joint by joint: the multiples of one joint's angle are built up from one another, once for all
            # of its orders.
            own = np.flatnonzero(table.joint == joint)
            weights = _waves(table.order[own], table.sine[own], rows.turn_rad[:, joint])
            found += [Term(k, Port(PortKind.THETA, joint), weights[i]) for i, k in enumerate(own.tolist())]
        return found

    def sums(self, names: tuple[str, ...], values: FloatArray, rows: Rows) -> dict[Port, FloatArray]:
        """Return the curves of the joints [rad], shape (n,) each, on their theta.

        Parameters as of `Summed.sums`.
        """
        table = _table(names)
        found = {}
        for joint in distinct_values(table.joint).tolist():
            own = table.joint == joint
            curve = _sum_of_waves(table.order[own], table.sine[own], values[own], rows.turn_rad[:, joint])
            found[Port(PortKind.THETA, joint)] = curve
        return found

    def unmodelled(self, setting: Setting, stops: Stops) -> bool:
        """Anywhere: gears and bearings are never round."""
        return True

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose of every joint that turns one wave per turn to two per turn of the motor, and a curve."""
        found = []
        # Anywhere else a wave of the angle is a constant.
        for joint in scene.turning:
            for order in orders(scene, joint):
                specs = wave_specs(joint, order)
                # Sine and cosine are added together or not at all: their phase is free.
                if specs[0].name not in scene.present:
                    found.append(Candidate(NAME, joint_subject(joint), specs, order))
            found += _curve(scene, joint)
        return tuple(found)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how large the waves are and what has that many waves per turn."""
        waves = fitted_waves(fitted)
        # A list of sixty orders tells nobody anything; how far the curve goes either way does.
        if len(waves) > _FEW_WAVES:
            return _describe_curve(subject, waves, fitted, scene)
        details = tuple(detail for wave in waves for detail in wave.details(several=len(waves) > 1))
        largest = max(waves, key=lambda wave: wave.amplitude_deg)
        joint = joint_of_subject(subject)
        sentence = message(
            "causes.joint_harmonics.wave" if len(waves) == 1 else "causes.joint_harmonics.waves",
            joint=subject,
            orders=tuple(spoken_order(order) for order in sorted(wave.order for wave in waves)),
            periods=periods(largest.order),
            amplitude_deg=largest.amplitude_deg,
            typical=_typical_of(largest.order, gear_ratio(scene, joint)),
        )
        return Description(subject, largest.amplitude_deg, "deg", largest.uncertainty_deg, sentence, details)


def _curve(scene: Scene, joint: int) -> list[Candidate]:
    """Propose the sum of all waves that a joint may have; none where the model has a curve of it."""
    waves = [wave_specs(joint, order) for order in np.arange(1.0, _HIGHEST_OF_CURVE + 1.0).tolist()]
    # Waves that the model has stay what they are. Once it has more than half of all of them it has the curve.
    left = tuple(spec for wave in waves for spec in wave if spec.name not in scene.present)
    if len(left) < len(waves):
        return []
    return [Candidate(NAME, joint_subject(joint), left, _HIGHEST_OF_CURVE, function=True)]


def _describe_curve(subject: str, waves: list[FittedWave], fitted: FittedCause, scene: Scene) -> Description:
    """Say how far a curve goes either way over what was measured, and which of its waves are the largest.

    The amplitude is half of peak to peak within the angles that were measured, with the uncertainty of that
    difference of two places of the curve.
    """
    turn = scene.turn_rad[:, joint_of_subject(subject)]
    # Within what was measured: beyond it the curve is held by nothing and may be of any size.
    angle = np.linspace(float(turn.min()), float(turn.max()), _ANGLES)
    weights = _weights(fitted.names, angle)
    curve = fitted.values @ weights
    ends = 0.5 * (weights[:, int(np.argmax(curve))] - weights[:, int(np.argmin(curve))])
    amplitude, uncertainty = np.rad2deg([fitted.values @ ends, np.sqrt(ends @ fitted.covariance @ ends)])
    largest = sorted(waves, key=lambda wave: -wave.amplitude_deg)[:_TOLD]
    sentence = message(
        "causes.joint_harmonics.curve",
        joint=subject,
        amplitude_deg=float(amplitude),
        orders=tuple(f"{wave.order:g}" for wave in sorted(largest, key=lambda wave: wave.order)),
    )
    details = tuple(detail for wave in largest for detail in wave.details(several=True))
    return Description(subject, float(amplitude), "deg", float(uncertainty), sentence, details)


class _Table(NamedTuple):
    """What the names of p parameters say."""

    joint: IntArray  # (p,) 0-based
    order: FloatArray  # (p,)
    sine: BoolArray  # (p,) else the cosine


@lru_cache
def _table(names: tuple[str, ...]) -> _Table:
    return _Table(
        np.array([joint_of_wave(name) for name in names]),
        np.array([order_of_wave(name) for name in names]),
        np.array([name.endswith("_sin") for name in names]),
    )


def _weights(names: tuple[str, ...], turn_rad: FloatArray) -> FloatArray:
    """Return the sines and cosines that parameters of one joint are of.

    Parameters
    ----------
    names : tuple of str
        p of them.
    turn_rad : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (p, n)
    """
    table = _table(names)
    return _waves(table.order, table.sine, turn_rad)


def _waves(order: FloatArray, sine: BoolArray, turn_rad: FloatArray) -> FloatArray:
    """Return sines and cosines of multiples of angles.

    Parameters
    ----------
    order : ndarray, shape (p,)
        Periods per turn.
    sine : ndarray of bool, shape (p,)
        Else the cosine.
    turn_rad : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (p, n)
    """
    if _are_few(order):
        angle = order[:, None] * turn_rad
        return np.where(sine[:, None], np.sin(angle), np.cos(angle))
    sines, cosines = _multiples(int(order.max()), turn_rad)
    row = order.astype(np.int64)
    return np.where(sine[:, None], sines[row], cosines[row])


def _are_few(order: FloatArray) -> bool:
    """Say whether it pays to work out each wave by itself; orders between whole ones have no other way."""
    return len(order) < _SHARE_OF_ORDERS * int(order.max()) or bool((order != np.round(order)).any())


def _sum_of_waves(order: FloatArray, sine: BoolArray, value: FloatArray, turn_rad: FloatArray) -> FloatArray:
    """Return the sum of waves (p,) at angles (n,): the real part of a polynomial in exp(i q), by Horner.

    s sin(k q) + c cos(k q) = Re((c - i s) exp(i k q)). For sixty orders of six joints at 10,000 rows a third
    of the time of the sum over all weights (docs/decisions/0039).
    """
    if _are_few(order):
        return np.asarray(value @ _waves(order, sine, turn_rad))
    coefficient = np.zeros(int(order.max()) + 1, dtype=complex)
    # Sine and cosine of one order go to the same coefficient: a plain assignment would keep the last of the
    # two.
    np.add.at(coefficient, order.astype(np.int64), np.where(sine, -1j, 1.0) * value)
    turn = np.exp(1j * turn_rad)
    curve = np.full(len(turn_rad), coefficient[-1])
    for factor in coefficient[-2::-1]:
        curve *= turn
        curve += factor
    return curve.real


def _multiples(highest: int, angle_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sines and cosines of 0..highest times angles (n,), shape (highest + 1, n), by addition theorems.

    sin((k + 1) q) = sin(k q) cos(q) + cos(k q) sin(q), likewise the cosine. A dozen times faster than a sine
    each; rounding grows to `highest` units of the last place.
    """
    sines, cosines = np.zeros((2, highest + 1, len(angle_rad)))
    cosines[0] = 1.0
    sine, cosine = np.sin(angle_rad), np.cos(angle_rad)
    for k in range(highest):
        sines[k + 1] = sines[k] * cosine + cosines[k] * sine
        cosines[k + 1] = cosines[k] * cosine - sines[k] * sine
    return sines, cosines


def _typical_of(order: float, ratio: float) -> Message:
    """Say what usually has that many waves per turn; `ratio` is the gear's, 0 where unknown."""
    # Known gears first: a wave at their cycle is told as theirs, although it might be called anything that
    # repeats.
    if ratio and abs(order - 2.0 * ratio) < 0.5:
        return message("typical.wave_generator")
    if ratio and abs(order - ratio) < 0.5:
        return message("typical.motor")
    if order <= 1.5:
        return message("typical.out_of_true")
    if order <= 2.5:
        return message("typical.oval")
    if not is_whole(order):
        return message("typical.inside_the_gear")
    return message("typical.repeats")
