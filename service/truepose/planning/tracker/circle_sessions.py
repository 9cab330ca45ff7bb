"""Sessions of the single-axis circle test: one joint turned at a time, up and down, one nest in sight.

Angles are whole steps from 0, as far as limits, table and column allow and the same nest faces the tracker:
of all nests the one with the longest unbroken row of stops, of several such the one farthest from the axis.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import PlannedStop, SessionPlan, Turn
from truepose.planning.work_volume.candidates import has_room
from truepose.planning.work_volume.sight import cosines_in_sight, is_seen
from truepose.planning.work_volume.work_space import (
    WorkSpace,
    nest_places,
    nominal_chain,
    require_consistent,
)

_MOST_STOPS: Final = 5000  # two days and nights of measuring
_FEWEST: Final = 5  # angles; four determine a circle, and one may be lost
_SHORTEST_RAD: Final = float(np.radians(20.0))  # on shorter arcs the axis is as uncertain as joints err
_BESIDE_AXIS_MM: Final = 20.0  # nearer, a tracker's reading tells angles to less than 0.05 deg
_ROUNDING: Final = 1e-9  # rad, and of a step


def usual_turns(n_joints: int) -> tuple[Turn, ...]:
    """Return intervals and steps of Table 2.3 (thesis of A. Nubiola, 2014), as many as there are joints."""
    table = ((60, 5), (40, 1), (40, 1), (155, 5), (90, 5), (400, 1))
    return tuple(
        Turn(joint, -float(np.radians(reach)), float(np.radians(reach)), float(np.radians(step)))
        for joint, (reach, step) in enumerate(table[:n_joints], start=1)
    )


def plan_circles(space: WorkSpace, template: SessionPlan, turns: Sequence[Turn] = ()) -> SessionPlan:
    """Fill the stops of a template with sweeps of the joints, all others at 0.

    Parameters
    ----------
    space : WorkSpace
    template : SessionPlan
        Role, speeds and all else; no stop is approached from elsewhere, since the side is what is tested.
    turns : sequence of Turn
        By default `usual_turns`; of these a joint that shows no nest far enough is left out.

    Raises
    ------
    ConfigurationError
        An interval is none, or the stops are too many. A joint that was asked for, or every joint, shows
        no nest over 20 deg and five angles.
    WorkSpaceError
        What is said of the cell contradicts itself.
    """
    require_consistent(space)
    wanted = turns or usual_turns(space.robot.n_joints)
    for turn in wanted:
        _require_possible(space, turn)
    sweeps = [_sweep(space, turn) for turn in wanted]
    kept = [sweep for sweep in sweeps if sweep.is_enough]
    lost = [sweep.joint for sweep in sweeps if not sweep.is_enough]
    if not kept or (turns and lost):
        raise ConfigurationError(_refused(lost))
    stops = tuple(_stops(kept))
    if len(stops) > _MOST_STOPS:
        raise ConfigurationError(
            f"These are {len(stops)} stops, {_MOST_STOPS} are the most: take larger steps."
        )
    return replace(template, stops=stops, approach_offset_rad=None)


@dataclass(frozen=True, slots=True)
class _Sweep:
    joint: int
    joints_rad: FloatArray  # (m, J) upwards
    nest: int

    @property
    def is_enough(self) -> bool:
        """Whether a circle can be fitted to it."""
        turned = self.joints_rad[:, self.joint - 1]
        return len(turned) >= _FEWEST and bool(np.ptp(turned) >= _SHORTEST_RAD - _ROUNDING)


def _require_possible(space: WorkSpace, turn: Turn) -> None:
    if not 1 <= turn.joint <= space.robot.n_joints:
        raise ConfigurationError(
            f"There is no joint {turn.joint}: {space.robot.name} has {space.robot.n_joints}."
        )
    if not (turn.lower_rad < turn.upper_rad and turn.step_rad > 0.0):
        raise ConfigurationError(f"Joint {turn.joint} is turned from below to above, in steps above 0.")


def _sweep(space: WorkSpace, turn: Turn) -> _Sweep:
    angles = _angles(turn)
    joints = np.zeros((len(angles), space.robot.n_joints))
    joints[:, turn.joint - 1] = angles
    chain = nominal_chain(space, joints)
    away = nest_places(space, chain) - chain.origin[turn.joint - 1]
    radius = np.linalg.norm(np.cross(away, chain.z[turn.joint - 1]), axis=2)
    seen = has_room(space, joints, chain) & is_seen(cosines_in_sight(space, chain))
    rows = [_longest(row) for row in seen & (radius >= _BESIDE_AXIS_MM)]
    best = max(range(len(rows)), key=lambda nest: (len(rows[nest]), float(radius[nest].mean())))
    return _Sweep(turn.joint, joints[rows[best]], best + 1)


def _angles(turn: Turn) -> FloatArray:
    """Return whole steps from 0 within the interval, ascending, shape (m,)."""
    first = np.ceil(turn.lower_rad / turn.step_rad - _ROUNDING)
    last = np.floor(turn.upper_rad / turn.step_rad + _ROUNDING)
    return np.asarray(np.arange(first, last + 1.0) * turn.step_rad)


def _longest(seen: BoolArray) -> IntArray:
    """Return the longest unbroken row of angles, shape (m,) indices."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return np.zeros(0, dtype=np.int64)
    longest = int(np.argmax(ends - starts))
    return np.arange(starts[longest], ends[longest])


def _stops(sweeps: Sequence[_Sweep]) -> Iterator[PlannedStop]:
    config = 0
    for sweep in sweeps:
        for joints in (*sweep.joints_rad, *sweep.joints_rad[-2::-1]):
            config += 1
            yield PlannedStop(config, tuple(joints.tolist()), sweep.nest)


def _refused(joints: Sequence[int]) -> str:
    listed = ", ".join(map(str, joints))
    return (
        f"Joint {listed}, all others at 0, shows the tracker no nest over 20 deg and {_FEWEST} angles in a "
        "row, within limits and clear of the table: take a smaller step, or a nest that is seen longer."
    )
