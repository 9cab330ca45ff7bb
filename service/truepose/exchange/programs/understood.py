"""How a program is meant, where the file does not say it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from truepose.exchange.programs.program import Pose


class Meant(StrEnum):
    """What the targets of a program are given in, beside its own work objects."""

    BASE = "base"  # of the robot
    WORLD = "world"  # of the readings that the model was made from


@dataclass(frozen=True, slots=True)
class Understood:
    """What whoever has a program corrected says of it beside the file."""

    meant: Meant = Meant.BASE
    defined: Mapping[str, Pose] = field(
        default_factory=dict
    )  # tools (in the flange) and work objects that it only names
    coupled: bool = False  # joint 3 of FANUC is counted from the horizontal: its joints may be corrected
    branch: int | None = None  # of poses whose branch the file says in words that are not understood
