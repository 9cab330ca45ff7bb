"""What a test of drift commands, ISO 9283:1998, 7.6: one pose from cold, in groups, while the robot works.

P1 is visited ten times in a group, each time from P2. Between two groups the arm goes round all five poses.
The first groups follow each other closely, since a cold robot changes fastest; after two hours half an hour
to an hour lies between two.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.session import PlannedStop, SessionPlan, Work
from truepose.judgement.iso9283.drift import LEAST_VISITS
from truepose.judgement.iso9283.plan import PosePlan

HOURS: Final = 8.0
_DUE_MIN: Final = (0, 10, 20, 30, 40, 50, 60, 75, 90, 120, 150, 180, 240, 300, 360, 420, 480)
_OVERTIME_S: Final = 180.0  # the groups have to span the hours from middle to middle


def drift_session(poses: PosePlan, nest: int, hours: float = HOURS) -> SessionPlan:
    """Return the groups as a session, which ends early where the drift has become slow.

    Parameters
    ----------
    poses : PosePlan
    nest : int
        1-based, of the tool.
    hours : float
        Until the last group is due; the standard has 8.

    Raises
    ------
    ConfigurationError
        Less than ten minutes, or more than eight hours.
    """
    if not _DUE_MIN[1] <= 60.0 * hours <= _DUE_MIN[-1]:
        raise ConfigurationError(f"A drift over {hours:g} h: give between 10 min and 8 h.")
    due_s = [60.0 * minute for minute in _DUE_MIN if minute <= 60.0 * hours]
    due_s[-1] += _OVERTIME_S
    stops = tuple(_stops(poses, nest, due_s))
    return SessionPlan("validation", stops, approach_offset_rad=None, ends_when_settled=True)


def _stops(poses: PosePlan, nest: int, due_s: list[float]) -> Iterator[PlannedStop]:
    p1, p2, *others = (tuple(row) for row in poses.joints_rad.tolist())
    round_trip = (*reversed(others), p2, p1)
    for config, (group, visit) in enumerate(np.ndindex(len(due_s), LEAST_VISITS), start=1):
        work = Work(due_s[group], round_trip) if group and not visit else None
        first = None if config == 1 else 1
        yield PlannedStop(config, p1, nest, first, begin_rad=p2, group=group + 1, work=work)
