"""What follows angles without a name: bearings that wobble, joints that follow others, parallelograms.

With q_s the source's own turn, n the order, `sin` and `cos` the parts:

    wobble   the link's body turns about x, y and shifts by   sin(n q), cos(n q)     q its own joint
    cross    theta_m moves by                                 sin(n q_s), cos(n q_s)
    along    theta_m moves by                                 share q_s
    pair     theta_m moves by                                 sin(n (q_1 +- q_2)), cos(n (q_1 +- q_2))

Of a pair of parallel axes q_1 +- q_2 is the turn of the second link in their plane; the sign is that of
cos(alpha).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.arm.geometry import is_parallel_to_previous
from truepose.effects.arm.joint_coupling import WRIST_JOINTS
from truepose.effects.causes import Scene
from truepose.effects.motions import COMPONENTS
from truepose.effects.names import joint_subject
from truepose.effects.ports import Port, PortKind, Rows, motion_port
from truepose.effects.unclassified.kinds import STEADY, Key, Kind, Moves, Part, Place, Size, Variants
from truepose.effects.waves import periods
from truepose.messages.message import Message, message

_WAVE_RAD = np.deg2rad(0.05)  # belief, as of waves of a joint's own angle
_SHARE = 2e-3  # belief, as of couplings within the wrist
_TILT_RAD, _RUNOUT_MM = 5e-4, 0.1  # belief: five times a bearing that runs visibly out of true
_WAVE = (Part("sin", "rad", _WAVE_RAD), Part("cos", "rad", _WAVE_RAD))
# What a bearing does beside the turn about its own axis, tilts first: they are the amplitude.
_WOBBLE = tuple(
    Part(f"{phase}-{component}", "rad" if "r" in component else "mm", width)
    for component, width in (("rx", _TILT_RAD), ("ry", _TILT_RAD), *((c, _RUNOUT_MM) for c in "xyz"))
    for phase in ("sin", "cos")
)


def _orders(highest: int) -> tuple[tuple[str, float], ...]:
    return tuple((str(order), float(order)) for order in range(1, highest + 1))


def _one_or_two(_scene: Scene) -> Variants:
    return _orders(2)


def _one_to_three(_scene: Scene) -> Variants:
    return _orders(3)


def _turning(scene: Scene) -> list[int]:
    return [joint + 1 for joint in scene.turning]


def _bodies(scene: Scene) -> list[Place]:
    return [(joint,) for joint in _turning(scene)]


def _others(scene: Scene) -> list[Place]:
    """Return every joint with every other one that turns."""
    joints = range(1, scene.setting.robot.n_joints + 1)
    return [(moved, source) for moved in joints for source in _turning(scene) if source != moved]


def _beyond_the_wrist(scene: Scene) -> list[Place]:
    """Return the joints that are no wrist joints: couplings of those have a name."""
    first = scene.setting.robot.n_joints - WRIST_JOINTS
    # Those of wrist joints are the trade's coupling: one thing must not have two names.
    return [place for place in _others(scene) if place[0] <= first]


def _parallel_pairs(scene: Scene) -> list[Place]:
    """Return the two joints of each pair of parallel axes, which a parallelogram may join, with the first."""
    robot, turning = scene.setting.robot, _turning(scene)
    return [
        (moved, first)
        # Both must turn: over one of them alone, their sum is its angle and the wave is one of that joint.
        for first in range(1, robot.n_joints)
        if is_parallel_to_previous(robot, first) and {first, first + 1} <= set(turning)
        for moved in (first, first + 1)
    ]


def _wave(phase: str, order: str, angle_rad: FloatArray) -> FloatArray:
    """Return sin or cos of the order times angles, shape (n,)."""
    wave = np.sin if phase == "sin" else np.cos
    return np.asarray(wave(float(order) * angle_rad))


def _theta(key: Key) -> Port:
    return Port(PortKind.THETA, key.place[0] - 1)


def _wobbles(key: Key, rows: Rows) -> Moves:
    """Move the body of a link: components of its motion [rad, mm], in its own axes."""
    joint = key.place[0]
    phase, component = key.part.split("-")
    weight = _wave(phase, key.variant, rows.turn_rad[:, joint - 1])
    return [(motion_port(joint, COMPONENTS.index(component)), weight)]


def _follows_in_waves(key: Key, rows: Rows) -> Moves:
    return [(_theta(key), _wave(key.part, key.variant, rows.turn_rad[:, key.place[1] - 1]))]


def _follows(key: Key, rows: Rows) -> Moves:
    return [(_theta(key), rows.turn_rad[:, key.place[1] - 1])]


def _follows_both(key: Key, rows: Rows) -> Moves:
    return [(_theta(key), _wave(key.part, key.variant, _summed(rows, key.place[1])))]


def _summed(rows: Rows, first: int) -> FloatArray:
    """Return how far the second of two parallel axes has turned its link in their plane, shape (n,)."""
    # Axes that point against each other turn the link back where the angle grows.
    same_way = np.sign(np.cos(rows.robot.joints[first].alpha_rad))
    return np.asarray(rows.turn_rad[:, first - 1] + same_way * rows.turn_rad[:, first])


def _periods(key: Key) -> Message:
    return periods(float(key.variant))


def _of_wobble(key: Key, size: Size, _scene: Scene) -> Message:
    return message(
        "causes.wobble",
        joint=_joint(key.place),
        tilt_deg=size.amplitude,
        shift_mm=size.beside,
        periods=_periods(key),
    )


def _of_cross_wave(key: Key, size: Size, _scene: Scene) -> Message:
    moved, source = map(joint_subject, _indices(key))
    return message(
        "causes.cross_wave",
        joint=moved,
        source=source,
        amplitude_deg=size.amplitude,
        periods=_periods(key),
    )


def _of_share(key: Key, size: Size, scene: Scene) -> Message:
    moved, source = _indices(key)
    way_deg = float(np.rad2deg(size.amplitude * float(np.ptp(scene.turn_rad[:, source]))))
    return message(
        "causes.moves_along",
        joint=joint_subject(moved),
        source=joint_subject(source),
        share=size.amplitude,
        way_deg=way_deg,
    )


def _of_pair(key: Key, size: Size, _scene: Scene) -> Message:
    _, first = key.place
    return message(
        "causes.pair_wave",
        joint=_joint(key.place),
        first=first,
        second=first + 1,
        amplitude_deg=size.amplitude,
        periods=_periods(key),
    )


def _indices(key: Key) -> tuple[int, ...]:
    """Return the joints of a place, from 0."""
    return tuple(number - 1 for number in key.place)


def _body(place: Place) -> str:
    return f"link {place[0]}"


def _joint(place: Place) -> str:
    return joint_subject(place[0] - 1)


def _own_angle(place: Place) -> str:
    return f"angle of joint {place[0]}"


def _other_angle(place: Place) -> str:
    return f"angle of joint {place[1]}"


def _both_angles(place: Place) -> str:
    return f"angles of joints {place[1]} and {place[1] + 1}"


_ORDER = ("order", "1")

KINDS = (
    Kind(
        "wobble", "wave", _WOBBLE, _body, _own_angle,
        _bodies, _one_or_two, _wobbles, _of_wobble, _ORDER,
    ),
    Kind(
        "cross", "wave", _WAVE, _joint, _other_angle,
        _others, _one_to_three, _follows_in_waves, _of_cross_wave, _ORDER,
    ),
    Kind(
        "along", "line", (Part("share", "1", _SHARE),), _joint, _other_angle,
        _beyond_the_wrist, lambda _scene: STEADY, _follows, _of_share,
    ),
    Kind(
        "pair", "wave", _WAVE, _joint, _both_angles,
        _parallel_pairs, _one_or_two, _follows_both, _of_pair, _ORDER,
    ),
)  # fmt: skip
