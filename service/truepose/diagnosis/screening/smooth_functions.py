"""Families: smooth dependences that any cause of a kind would leave, whatever its formula.

Each family is a set of columns taken together as one random effect. They do not name a cause; they say what
is left depends on: a joint's angle, a torque, direction, time, temperature, place, nest, attachment.

A curve of an angle q is sum_k (a_k cos k q + b_k sin k q) / k, a course of time t is the sum over k of c_k
cos(pi k t / T) / k. With weights of one variance their amplitudes fall as 1 / k, as those of a random walk
do. Shapes that turn something are divided by a lever, so that a weight of one is about a millimetre at the
tool in every family. The choice of these functions is our own.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.effects.causes import Scene, has_spread
from truepose.effects.ports import Port, PortKind, Term, motion_port
from truepose.identification.model.evaluation import State

_FOURIER = 6  # waves per turn up to which a curve of an angle counts as smooth
_COSINES = 8  # half periods over a campaign up to which a course of time does
_LEVER_MM = 300.0  # how many mm a rad is worth: about a forearm
_BEARING_N_MM = 2000.0  # gears settle within such a torque
# Powers of x, y, z; place and slope are the base's own.
_PLACE_DEGREES = (
    (2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1),
    (3, 0, 0), (0, 3, 0), (0, 0, 3), (2, 1, 0), (2, 0, 1), (0, 2, 1), (1, 2, 0), (1, 0, 2), (0, 1, 2),
    (1, 1, 1),
)  # fmt: skip

Acting = list[tuple[Port, FloatArray]]  # one parameter that moves several ports together
Builder = Callable[[State], list[Acting]]


@dataclass(frozen=True, slots=True)
class Family:
    """A smooth dependence on one variable.

    Attributes
    ----------
    variable : str
        As reported, e.g. "angle of joint 4".
    kind : str
        "angle", "coupling", "torque", "direction", "time", "temperature", "attachment", "nest" or "place".
    build : callable
        From a state of n readings to its parameters; the same number of them in every block.
    joint : int or None
        0-based.
    """

    variable: str
    kind: str
    build: Builder
    joint: int | None = None


def families(scene: Scene) -> tuple[Family, ...]:
    """Return the families that these data can show.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    tuple of Family
        None of a variable that is unknown or that does not vary.
    """
    # A joint that turned by less shows no curve of its own: its few waves are one straight line.
    joints = [
        j for j in range(scene.setting.robot.n_joints) if np.ptp(scene.turn_rad[:, j]) > np.deg2rad(5.0)
    ]
    found = [family(j) for j in joints for family in (_angle, _trend)]
    found += [_coupling(j, scene.setting.robot.n_joints) for j in joints]
    found += [_torque(j) for j in _loaded(scene)]
    found += [_direction(j) for j in joints if _has_directions(scene, j)]
    if scene.stops.time_s is not None and has_spread(scene.stops.time_s):
        span = _span(scene.stops.time_s)
        found += [_time(what, span) for what in ("place", "tool", "lengths")]
        # Without fixed nests the frame of the instrument and the place of the base move readings alike.
        if len(scene.reference_s):
            found.append(_time("instrument", span))
    if scene.stops.temperature_c is not None and has_spread(scene.stops.temperature_c):
        found.append(_temperature(float(np.nanmean(scene.stops.temperature_c))))
    if scene.stops.attachment is not None and has_spread(scene.stops.attachment):
        found.append(_attachment(scene.stops.attachment))
    nests = np.unique(scene.nest)
    if len(nests) > 1:
        found.append(_nest(nests.tolist()))
    found.append(_place(scene))
    return tuple(found)


def terms_of(family: Family, state: State) -> tuple[Term, ...]:
    """Return the family's terms.

    Parameters
    ----------
    family : Family
    state : State
        At n readings.

    Returns
    -------
    tuple of Term
        Weights of shape (n,); parameters are numbered from 0.
    """
    return tuple(
        Term(parameter, port, weight)
        for parameter, acting in enumerate(family.build(state))
        for port, weight in acting
    )


def _loaded(scene: Scene) -> list[int]:
    """Return the joints (0-based) whose torque varies by more than 1 N mm."""
    if scene.torque_n_mm is None:
        return []
    return np.flatnonzero(np.nan_to_num(np.ptp(scene.torque_n_mm, axis=0)) > 1.0).tolist()


def _has_directions(scene: Scene, joint: int) -> bool:
    """Whether a joint (0-based) is known to have come from more than one side."""
    return scene.stops.direction is not None and has_spread(scene.stops.direction[:, joint])


def _span(time_s: FloatArray) -> tuple[float, float]:
    """Return the first time and the length of a campaign [s], at least one second."""
    return float(np.nanmin(time_s)), float(max(np.ptp(time_s[np.isfinite(time_s)]), 1.0))


def _turn(state: State, joint: int) -> FloatArray:
    """Return the angle of a joint about its own axis, shape (n,) [rad]."""
    sign = state.structure.robot.joints[joint].sign
    return np.asarray(sign * state.targets.stops.joints_rad[:, joint])


def _waves(angle: FloatArray, highest: int) -> list[FloatArray]:
    """Return cosine and sine of each order at the angles (n,) [rad], divided by the order."""
    return [wave(k * angle) / k for k in range(1, highest + 1) for wave in (np.cos, np.sin)]


def _angle(joint: int) -> Family:
    """Return a curve of one joint over its own angle."""
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        return [[(port, wave / _LEVER_MM)] for wave in _waves(_turn(state, joint), _FOURIER)]

    return Family(f"angle of joint {joint + 1}", "angle", build, joint)


def _trend(joint: int) -> Family:
    """Return a straight line: the plainest of all shapes, which waves can only patch together."""
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        return [[(port, _turn(state, joint) / _LEVER_MM)]]

    return Family(f"angle of joint {joint + 1}", "angle", build, joint)


def _coupling(source: int, n_joints: int) -> Family:
    """Return curves of all other joints over the angle of one."""

    def build(state: State) -> list[Acting]:
        waves = _waves(_turn(state, source), 3)
        return [
            [(Port(PortKind.THETA, moved), wave / _LEVER_MM)]
            for moved in range(n_joints)
            if moved != source
            for wave in waves
        ]

    return Family(f"angle of joint {source + 1}, in other joints", "coupling", build, source)


def _torque(joint: int) -> Family:
    """Return a joint's error over its torque: what is left of a spring that is not linear."""
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        torque = state.torque_n_mm
        load = np.zeros(len(state.targets)) if torque is None else np.nan_to_num(torque[:, joint])
        relative = load / max(float(np.abs(load).max(initial=0.0)), 1.0)
        # No straight line: what is linear in the torque is the compliance's own.
        shapes = (np.abs(relative), relative * np.abs(relative), relative**3, np.tanh(load / _BEARING_N_MM))
        return [[(port, shape / _LEVER_MM)] for shape in shapes]

    return Family(f"torque of joint {joint + 1}", "torque", build, joint)


def _direction(joint: int) -> Family:
    """Return a joint's error by the side that it came from."""
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        direction = state.targets.stops.direction
        side = np.zeros(len(state.targets)) if direction is None else np.sign(direction[:, joint])
        return [[(port, side / _LEVER_MM)]]

    return Family(f"direction of joint {joint + 1}", "direction", build, joint)


def _time(what: str, span: tuple[float, float]) -> Family:
    """Return a course over time of the base, the tool, the lengths of the arm, or the instrument."""

    def build(state: State) -> list[Acting]:
        time_s = state.targets.stops.time_s
        n = len(state.targets)
        if time_s is None:
            # Other blocks may not tell times (sides of the fixture, say); the number of parameters must be
            # the same.
            shapes = [np.zeros(n)] * _COSINES
        else:
            # A reading without a time takes no part; 0.5 only keeps NaN out of the cosine.
            share = np.nan_to_num((time_s - span[0]) / span[1], nan=0.5)
            known = np.isfinite(time_s)
            shapes = [known * np.cos(np.pi * k * share) / k for k in range(1, _COSINES + 1)]
        return [acting for shape in shapes for acting in _acting(what, state, shape)]

    names = {
        "place": "time (place of the base)",
        "tool": "time (seat of the tool)",
        "lengths": "time (lengths of the arm)",
        "instrument": "time (frame of the instrument)",
    }
    return Family(names[what], "time", build)


def _acting(what: str, state: State, shape: FloatArray) -> list[Acting]:
    """Return the parameters by which something moves as a shape (n,) does, angles in units of the lever."""
    joints = state.structure.robot.n_joints
    levers = (1.0, 1.0, 1.0, _LEVER_MM, _LEVER_MM, _LEVER_MM)
    match what:
        case "place":
            return [[(motion_port(0, c), shape / lever)] for c, lever in enumerate(levers)]
        case "tool":
            return [[(motion_port(joints, c), shape / lever)] for c, lever in enumerate(levers)]
        case "instrument":
            return [[(Port(PortKind.INSTRUMENT, c), shape / lever)] for c, lever in enumerate(levers)]
        case _:
            return [_longer(state, shape / _LEVER_MM)]


def _longer(state: State, share: FloatArray) -> Acting:
    """Return one parameter that stretches all lengths of the arm together, as heat does."""
    found: Acting = []
    for number, row in enumerate(state.structure.robot.joints):
        found.append((Port(PortKind.A, number), share * row.a_mm))
        found.append((Port(PortKind.D, number), share * row.d_mm))
    return found


def _temperature(mean_c: float) -> Family:
    """Return angles, lengths and the place of the base over the temperature, from its mean [degC]."""

    def build(state: State) -> list[Acting]:
        temperature = state.targets.stops.temperature_c
        n = len(state.targets)
        warmer = np.zeros(n) if temperature is None else np.nan_to_num(temperature - mean_c)
        angles: list[Acting] = [
            [(Port(PortKind.THETA, joint), warmer / _LEVER_MM)]
            for joint in range(state.structure.robot.n_joints)
        ]
        return [*angles, *(part for what in ("lengths", "place") for part in _acting(what, state, warmer))]

    return Family("temperature", "temperature", build)


def _attachment(mountings: IntArray) -> Family:
    """Return another place of the tool for each mounting."""
    numbers = np.unique(mountings[np.isfinite(mountings)]).tolist()

    def build(state: State) -> list[Acting]:
        attachment = state.targets.stops.attachment
        found: list[Acting] = []
        for number in numbers:
            here = np.zeros(len(state.targets)) if attachment is None else 1.0 * (attachment == number)
            found += _acting("tool", state, here)
        return found

    return Family("attachment of the tool", "attachment", build)


def _nest(numbers: list[int]) -> Family:
    """Return another place for each nest."""

    def build(state: State) -> list[Acting]:
        one = np.ones(len(state.targets))
        return [[(Port(PortKind.NEST, 3 * (number - 1) + c), one)] for number in numbers for c in range(3)]

    return Family("nest", "nest", build)


def _place(scene: Scene) -> Family:
    """Return readings that are off by a polynomial of their place: a distorted field of the instrument."""
    points = scene.chain.end_origin
    centre, reach = points.mean(axis=0), max(float(points.std()), 1.0)

    def build(state: State) -> list[Acting]:
        # Twice the spread: nearly all places then lie within -1 to 1, and no power outweighs the others.
        relative = (state.unscaled_mm - centre) / (2.0 * reach)
        shapes = [np.prod(relative ** np.array(powers), axis=1) for powers in _PLACE_DEGREES]
        return [[(Port(PortKind.INSTRUMENT, c), shape)] for shape in shapes for c in range(3)]

    return Family("place in the work space", "place", build)
