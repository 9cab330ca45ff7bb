"""What follows the last move without a name: a joint that has not yet settled when it is measured."""

import numpy as np

from truepose.domain.sentences import Sentence, said
from truepose.effects.causes import Scene
from truepose.effects.names import joint_subject
from truepose.effects.ports import Port, PortKind, Rows
from truepose.effects.unnamed.kinds import STEADY, Key, Kind, Moves, Part, Place, Size, once

_SHARE = 1e-3  # belief: 0.05 deg after 50 deg, five times what an operator sees creeping
_SMALLEST_MOVE_RAD = np.deg2rad(5.0)  # root mean square; over less, a share of a move is nothing


def _moving(scene: Scene) -> list[Place]:
    if scene.stops.move_rad is None:
        return []
    usual = np.sqrt(np.mean(np.nan_to_num(scene.stops.move_rad) ** 2, axis=0))
    return [(joint,) for joint in (np.flatnonzero(usual >= _SMALLEST_MOVE_RAD) + 1).tolist()]


def _lags(key: Key, rows: Rows) -> Moves:
    joint = key.place[0] - 1
    port = Port(PortKind.THETA, joint)
    if rows.stops.move_rad is None:
        return [(port, np.zeros(len(rows.stops)))]
    return [(port, -rows.robot.joints[joint].sign * np.nan_to_num(rows.stops.move_rad[:, joint]))]


def _of_lag(key: Key, size: Size, scene: Scene) -> Sentence:
    joint, moves = key.place[0] - 1, scene.stops.move_rad
    largest = 0.0 if moves is None else float(np.nanmax(np.abs(moves[:, joint])))
    most_deg = float(np.rad2deg(size.amplitude * largest))
    return said("causes.lag", joint=joint_subject(joint), share=size.amplitude, most_deg=most_deg)


KINDS = (
    Kind(
        "lag", "line", (Part("share", "1", _SHARE),), lambda place: joint_subject(place[0] - 1),
        once("last move"), _moving, lambda _scene: STEADY, _lags, _of_lag, needs=frozenset({"move"}),
    ),
)  # fmt: skip
