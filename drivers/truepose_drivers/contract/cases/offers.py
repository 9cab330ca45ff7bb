"""What a driver says of itself before anything is connected, and targets that a robot must refuse."""

import inspect
import math
from collections.abc import Awaitable, Mapping
from typing import Final

from truepose_drivers.api import (
    Ballbar,
    Clock,
    DeviceKind,
    LinearGauge,
    MotionLimits,
    PointTracker,
    PoseTracker,
    RobotController,
    SimulatedHands,
)
from truepose_drivers.contract.case import Trial, broken, case
from truepose_drivers.errors import ConfigurationError, DriverError, TargetRefusedError
from truepose_drivers.guard import guarded
from truepose_drivers.plausibility import ABILITIES

_FEWEST_WORDS: Final = 3  # of a sentence
_WOUND_UP_RAD: Final = 100.0  # sixteen turns: no joint of an arm is wound up further
_PROTOCOLS: Final[Mapping[DeviceKind, type]] = {
    "tracker": PointTracker,
    "pose_tracker": PoseTracker,
    "robot": RobotController,
    "ballbar": Ballbar,
    "linear_gauge": LinearGauge,
    "hands": SimulatedHands,
    "clock": Clock,
}


@case(remedy="write the members that the Protocol of its kind in truepose_drivers.api has, async where it is")
async def it_offers_all_of_its_kind(trial: Trial) -> None:
    """A driver has every method of its kind, with async where the API has it."""
    for kind in (trial.bench.plugin.kind, *trial.bench.plugin.also):
        if missing := _missing(_PROTOCOLS[kind], type(trial.device)):
            broken(f"for a {kind} the driver lacks {', '.join(missing)}, or has it without async")


@case(remedy="write it as its Protocol in truepose_drivers.api has it: same type, async where that is")
async def its_abilities_reach_the_service(trial: Trial) -> None:
    """What a driver offers beyond its kind has the form of the API, so that its guard says the same."""
    plugin = trial.bench.plugin
    for kind in (plugin.kind, *plugin.also):
        behind = guarded(plugin.name, kind, trial.device)
        lost = [name for name, member in _abilities(kind) if _is_lost(name, member, trial.device, behind)]
        if lost:
            broken(f"for a {kind} {', '.join(lost)} does not come through the guard")


def _abilities(kind: DeviceKind) -> list[tuple[str, object]]:
    return [
        (name, member)
        for ability in ABILITIES.get(kind, ())
        for name, member in vars(ability).items()
        if not name.startswith("_")
    ]


def _is_lost(name: str, member: object, device: object, behind: object) -> bool:
    if not hasattr(device, name):
        return False
    if inspect.iscoroutinefunction(member):
        return not inspect.iscoroutinefunction(getattr(device, name))
    return bool(getattr(behind, name) != getattr(device, name))


def _missing(protocol: type, offered: type) -> list[str]:
    wanted = {name: member for name, member in inspect.getmembers(protocol) if not name.startswith("_")}
    return [
        name
        for name, member in wanted.items()
        if not hasattr(offered, name)
        or inspect.iscoroutinefunction(member) != inspect.iscoroutinefunction(getattr(offered, name))
    ]


@case(remedy="describe each option of PLUGIN for the person who writes a cell file")
async def its_options_are_explained(trial: Trial) -> None:
    """Every option of the cell file has a sentence."""
    terse = [name for name, words in trial.bench.plugin.options.items() if len(words.split()) < _FEWEST_WORDS]
    if terse:
        broken(f"the options {', '.join(terse)} have no description")


@case(
    kinds=("robot",),
    remedy="check number, finiteness and size of the joints before anything is sent: TargetRefusedError",
)
async def a_target_that_is_none_moves_nothing(trial: Trial) -> None:
    """A target of too few or too many joints, not finite or wound up is refused, and nothing is sent."""
    await trial.reach()
    joints = len((await trial.device.read_joints()).joints_rad)
    for target_rad in _no_targets(joints):
        trial.wiring.sent.clear()
        await _refused(trial.device.move_joints(target_rad), TargetRefusedError, f"the target {target_rad}")
        if trial.wiring.sent:
            broken(f"the driver sent {trial.wiring.sent[-1]!r} for the target {target_rad}")


def _no_targets(joints: int) -> list[tuple[float, ...]]:
    others = (0.0,) * (joints - 1)
    return [
        (),
        others,
        (0.0,) * (joints + 1),
        *((bad_rad, *others) for bad_rad in (math.nan, math.inf, _WOUND_UP_RAD)),
    ]


@case(
    kinds=("robot",),
    remedy="refuse a speed of the tool or of its turning that is not finite and positive: ConfigurationError",
)
async def a_speed_that_is_none_is_refused(trial: Trial) -> None:
    """Limits that are zero, negative or not finite are refused, and nothing is sent."""
    await trial.reach()
    for speed in (0.0, -1.0, math.nan, math.inf):
        for limits in (MotionLimits(tool_speed_mm_s=speed), MotionLimits(orientation_speed_rad_s=speed)):
            trial.wiring.sent.clear()
            await _refused(trial.device.set_limits(limits), ConfigurationError, f"{limits}")
            if trial.wiring.sent:
                broken(f"the driver sent {trial.wiring.sent[-1]!r} for {limits}")


async def _refused(doing: Awaitable[object], error: type[DriverError], what: str) -> None:
    try:
        await doing
    except error:
        return
    except DriverError as other:
        broken(f"{what} is refused with {other!r}, which is no {error.__name__}")
    broken(f"the driver took {what}")
