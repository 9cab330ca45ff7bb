"""What a driver says of itself before anything is connected."""

import inspect
from collections.abc import Mapping
from typing import Final

from truepose_drivers.api import (
    Ballbar,
    Clock,
    DeviceKind,
    LinearGauge,
    PointTracker,
    PoseTracker,
    RobotController,
    SimulatedHands,
)
from truepose_drivers.contract.case import case
from truepose_drivers.contract.trial import Trial, broken

_FEWEST_WORDS: Final = 3  # of a sentence
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


def _missing(protocol: type, offered: type) -> list[str]:
    wanted = {name: member for name, member in inspect.getmembers(protocol) if not name.startswith("_")}
    return [
        name
        for name, member in wanted.items()
        if not hasattr(offered, name)
        or inspect.iscoroutinefunction(member) != inspect.iscoroutinefunction(getattr(offered, name))
    ]


@case(remedy="say of each option of PLUGIN what it is, in the words of whoever writes a cell file")
async def its_options_are_explained(trial: Trial) -> None:
    """Every option of the cell file has a sentence."""
    terse = [name for name, words in trial.bench.plugin.options.items() if len(words.split()) < _FEWEST_WORDS]
    if terse:
        broken(f"the options {', '.join(terse)} have no sentence")
