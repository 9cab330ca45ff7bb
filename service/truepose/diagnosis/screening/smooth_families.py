"""Families: smooth dependences that any cause of a kind would leave, whatever its formula.

Each family is a set of columns taken together as one random effect. They do not name a cause; they say what
is left depends on: a joint's angle, a torque, direction, time, temperature, place, nest, attachment.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.effects.causes import Scene, varied
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
    """A smooth dependence on one variable."""

    variable: str  # as it is told: "angle of joint 4"
    # "angle", "coupling", "torque", "direction", "time", "temperature", "attachment", "nest" or "place"
    kind: str
    build: Builder  # the same number of parameters in every block
    joint: int | None = None  # 0-based


def families(scene: Scene) -> tuple[Family, ...]:
    """Return the families that these data can show."""
    joints = [
        j for j in range(scene.setting.robot.n_joints) if np.ptp(scene.turn_rad[:, j]) > np.deg2rad(5.0)
    ]
    found = [family(j) for j in joints for family in (_angle, _trend)]
    found += [_coupling(j, scene.setting.robot.n_joints) for j in joints]
    found += [_torque(j) for j in _loaded(scene)]
    found += [_direction(j) for j in joints if _has_directions(scene, j)]
    if scene.stops.time_s is not None and varied(scene.stops.time_s):
        span = _span(scene.stops.time_s)
        found += [_time(what, span) for what in ("place", "tool", "lengths")]
        if len(scene.reference_s):
            found.append(_time("instrument", span))
    if scene.stops.temperature_c is not None and varied(scene.stops.temperature_c):
        found.append(_temperature(float(np.nanmean(scene.stops.temperature_c))))
    if scene.stops.attachment is not None and varied(scene.stops.attachment):
        found.append(_attachment(scene.stops.attachment))
    nests = np.unique(scene.nest)
    if len(nests) > 1:
        found.append(_nest(nests.tolist()))
    found.append(_place(scene))
    return tuple(found)


def terms_of(family: Family, state: State) -> tuple[Term, ...]:
    """Return the family's terms, its parameters numbered from 0."""
    return tuple(
        Term(parameter, port, weight)
        for parameter, acting in enumerate(family.build(state))
        for port, weight in acting
    )


def _loaded(scene: Scene) -> list[int]:
    if scene.torque_n_mm is None:
        return []
    return np.flatnonzero(np.nan_to_num(np.ptp(scene.torque_n_mm, axis=0)) > 1.0).tolist()


def _has_directions(scene: Scene, joint: int) -> bool:
    return scene.stops.direction is not None and varied(scene.stops.direction[:, joint])


def _span(time_s: FloatArray) -> tuple[float, float]:
    return float(np.nanmin(time_s)), float(max(np.ptp(time_s[np.isfinite(time_s)]), 1.0))


def _turn(state: State, joint: int) -> FloatArray:
    sign = state.structure.robot.joints[joint].sign
    return np.asarray(sign * state.targets.stops.joints_rad[:, joint])


def _waves(angle: FloatArray, highest: int) -> list[FloatArray]:
    return [wave(k * angle) / k for k in range(1, highest + 1) for wave in (np.cos, np.sin)]


def _angle(joint: int) -> Family:
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
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        torque = state.torque_n_mm
        load = np.zeros(len(state.targets)) if torque is None else np.nan_to_num(torque[:, joint])
        relative = load / max(float(np.abs(load).max(initial=0.0)), 1.0)
        shapes = (np.abs(relative), relative * np.abs(relative), relative**3, np.tanh(load / _BEARING_N_MM))
        return [[(port, shape / _LEVER_MM)] for shape in shapes]

    return Family(f"torque of joint {joint + 1}", "torque", build, joint)


def _direction(joint: int) -> Family:
    port = Port(PortKind.THETA, joint)

    def build(state: State) -> list[Acting]:
        direction = state.targets.stops.direction
        side = np.zeros(len(state.targets)) if direction is None else np.sign(direction[:, joint])
        return [[(port, side / _LEVER_MM)]]

    return Family(f"direction of joint {joint + 1}", "direction", build, joint)


def _time(what: str, span: tuple[float, float]) -> Family:
    def build(state: State) -> list[Acting]:
        time_s = state.targets.stops.time_s
        n = len(state.targets)
        if time_s is None:
            shapes = [np.zeros(n)] * _COSINES
        else:
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
    found: Acting = []
    for number, row in enumerate(state.structure.robot.joints):
        found.append((Port(PortKind.A, number), share * row.a_mm))
        found.append((Port(PortKind.D, number), share * row.d_mm))
    return found


def _temperature(mean_c: float) -> Family:
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
    def build(state: State) -> list[Acting]:
        one = np.ones(len(state.targets))
        return [[(Port(PortKind.NEST, 3 * (number - 1) + c), one)] for number in numbers for c in range(3)]

    return Family("nest", "nest", build)


def _place(scene: Scene) -> Family:
    points = scene.chain.end_origin
    centre, reach = points.mean(axis=0), max(float(points.std()), 1.0)

    def build(state: State) -> list[Acting]:
        relative = (state.unscaled_mm - centre) / (2.0 * reach)
        shapes = [np.prod(relative ** np.array(powers), axis=1) for powers in _PLACE_DEGREES]
        return [[(Port(PortKind.INSTRUMENT, c), shape)] for shape in shapes for c in range(3)]

    return Family("place in the work space", "place", build)
