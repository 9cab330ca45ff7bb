"""Faults of the cables between an instrument or a controller and whoever asks it."""

from dataclasses import dataclass

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.times import Lasting

_WITH_LINK = ("tracker", "robot", "ballbar", "pose_tracker", "clock")


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkFault(Lasting):
    """Something about all connections of `device`, its further ports included."""

    device: str

    def __post_init__(self) -> None:
        Lasting.__post_init__(self)
        if self.device not in _WITH_LINK:
            raise ScenarioError(f'key "device" must be one of {", ".join(_WITH_LINK)}, not {self.device!r}')


class LinkCut(LinkFault):
    """Connections break, and new ones are hung up on."""


class LinkHalfOpen(LinkFault):
    """Connections stay, and every word on them is lost, either way."""
