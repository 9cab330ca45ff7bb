"""Daily: the zero of a joint goes up and down once a day, as in a hall that the sun shines into.

A cell without a name is one `Kind`: where it acts, over what, in which shape, its parameters, what each of
them moves, and its sentence.
"""

import numpy as np

from truepose.effects.causes import Scene
from truepose.effects.names import joint_subject
from truepose.effects.ports import Port, PortKind, Rows
from truepose.effects.unclassified.kinds import Key, Kind, Moves, Part, Place, Size

_DAY_S = 86_400.0
_WIDTH = np.deg2rad(0.02)  # belief: five times what an operator would notice from morning to noon


def _joints(scene: Scene) -> list[Place]:
    """Look for it where the readings take half a day: over less it is a drift."""
    time_s = scene.stops.time_s
    if time_s is None or np.ptp(time_s[np.isfinite(time_s)]) < _DAY_S / 2.0:
        return []
    return [(joint + 1,) for joint in range(scene.setting.robot.n_joints)]


def _turns(key: Key, rows: Rows) -> Moves:
    """Turn the joint; a row that does not tell its time gets nothing."""
    port = Port(PortKind.THETA, key.place[0] - 1)
    if rows.stops.time_s is None:
        return [(port, np.zeros(len(rows.stops)))]
    wave = np.sin if key.part == "sin" else np.cos
    return [(port, np.nan_to_num(wave(2.0 * np.pi * rows.stops.time_s / _DAY_S)))]


def _sentence(key: Key, size: Size, _scene: Scene) -> str:
    return f"The zero of joint {key.place[0]} goes up and down by {size.amplitude:.4f} deg once a day."


BROUGHT = Kind(
    name="daily",
    shape="wave",
    parts=(Part("sin", "rad", _WIDTH), Part("cos", "rad", _WIDTH)),
    where=lambda place: joint_subject(place[0] - 1),
    over=lambda _place: "time",
    places=_joints,
    variants=lambda _scene: [("day", 1.0)],
    moves=_turns,
    sentence=_sentence,
    needs=frozenset({"time"}),
)
