"""What a driver may offer beyond its kind, asked of the driver itself: here, and nowhere behind its guard.

Looked up by name, as a Python that calls the member would: a runtime protocol sees nothing that a driver
passes on with `__getattr__`.
"""

import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, TypeAlias

from truepose_drivers.api import (
    BallbarReading,
    DeviceKind,
    GuardsMotion,
    LinearGauge,
    MotionGuard,
    ReadsChannels,
    ShowsReflector,
    StatesSettings,
    Vector,
)
from truepose_drivers.plausibility import readable_sentence

ABILITIES: Final[Mapping[DeviceKind, tuple[type, ...]]] = {
    "tracker": (StatesSettings, ShowsReflector),
    "pose_tracker": (StatesSettings,),
    "robot": (GuardsMotion,),
    "linear_gauge": (ReadsChannels,),
}
AskReflector: TypeAlias = Callable[[], Awaitable[Vector | None]]


def motion_guard_of(driver: object) -> MotionGuard:
    """Return what a robot's driver says of its motions; where it says nothing or nonsense, the worst."""
    stated = _stated(driver, "motion_guard")
    plausible = isinstance(stated, MotionGuard) and all(
        seconds is None or (_is_number(seconds) and 0.0 < seconds < math.inf)
        for seconds in (stated.stops_unheard_s, stated.longest_piece_s)
    )
    return stated if isinstance(stated, MotionGuard) and plausible else MotionGuard()


def settings_of(driver: object) -> str:
    """Return what an instrument's driver says that it measures with; empty where it cannot tell."""
    stated = _stated(driver, "settings")
    return readable_sentence(stated) if isinstance(stated, str) else ""


def reflector_of(driver: object) -> AskReflector | None:
    """Return what asks a tracker's driver for the reflector, None where it does not offer that."""
    return getattr(driver, "reflector_now", None)


async def channels_of(driver: LinearGauge) -> tuple[BallbarReading, ...]:
    """Return what all gauges of a box show; of a driver that knows no box, what its one gauge does."""
    read_channels = getattr(driver, "read_channels", None)
    return (await driver.read(),) if read_channels is None else await read_channels()


def _stated(driver: object, name: str) -> Any:
    try:
        return getattr(driver, name, None)
    except Exception:  # whatever foreign code does in a property
        return None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
