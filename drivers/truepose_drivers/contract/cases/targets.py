"""What only robots are asked: targets and speeds that are none."""

import math
from collections.abc import Awaitable

from truepose_drivers.api import MotionLimits
from truepose_drivers.contract.case import case
from truepose_drivers.contract.trial import Trial, broken
from truepose_drivers.errors import DriverError, TargetRefusedError


@case(
    kinds=("robot",),
    remedy="check number and finiteness of the joints before anything is sent; raise TargetRefusedError",
)
async def a_target_that_is_none_moves_nothing(trial: Trial) -> None:
    """A target of no joints, of too few or not finite is refused, and nothing is sent."""
    await trial.reach()
    joints = len((await trial.device.read_joints()).joints_rad)
    for target_rad in ((), (0.0,) * (joints - 1), (math.nan,) * joints, (math.inf,) * joints):
        trial.wiring.sent.clear()
        await _refused(trial.device.move_joints(target_rad), TargetRefusedError, f"the target {target_rad}")
        if trial.wiring.sent:
            broken(f"the driver sent {trial.wiring.sent[-1]!r} for the target {target_rad}")


@case(
    kinds=("robot",),
    remedy="refuse a speed that is not finite and positive, with ConfigurationError",
)
async def a_speed_that_is_none_is_refused(trial: Trial) -> None:
    """Limits that are zero, negative or not finite are refused."""
    await trial.reach()
    for speed in (0.0, -1.0, math.nan):
        await _refused(
            trial.device.set_limits(MotionLimits(tool_speed_mm_s=speed)), DriverError, f"{speed} mm/s"
        )


async def _refused(doing: Awaitable[object], error: type[DriverError], what: str) -> None:
    try:
        await doing
    except error:
        return
    except DriverError as other:
        broken(f"{what} is refused with {other!r}, which is no {error.__name__}")
    broken(f"the driver took {what}")
