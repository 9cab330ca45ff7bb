"""What whoever has a file of targets corrected says of it beside the file."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from truepose.domain.errors import ConfigurationError
from truepose.exchange.programs.branches import branch_of_words
from truepose.exchange.programs.program import Pose
from truepose.exchange.programs.understood import Meant, Understood

_UNIT: Final = 1e-6  # of the length of a quaternion


@dataclass(frozen=True, slots=True)
class Asked:
    """How a file is meant; what does not concern its format does not matter."""

    meant: Meant | None = None  # None: a table in the world of the readings, a program in the base
    defined: Mapping[str, Pose] = field(default_factory=dict)
    coupled: bool = False
    branch: int | None = None
    angles: str | None = None
    beside: Mapping[str, bytes] = field(default_factory=dict)
    as_written: bool = False  # also where another unit or frame fits better, or nearly all is out of reach
    most_targets: int | None = None  # more are refused; None: as many as are read

    @property
    def understood(self) -> Understood:
        """What of it concerns a program."""
        return Understood(self.meant or Meant.BASE, self.defined, self.coupled, self.branch)


def branch_named(words: str, option: str) -> int:
    """Return the branch of such words as front/up/no flip; raises ConfigurationError."""
    found = branch_of_words(words)
    if found is None:
        raise ConfigurationError(f"{option} {words}: name one such as front/up/no flip or back/down/flip.")
    return found


def frame_defined(text: str, option: str) -> tuple[str, Pose]:
    """Return name and pose that `NAME=x,y,z,qw,qx,qy,qz` says; raises ConfigurationError."""
    name, _, numbers = text.partition("=")
    try:
        x, y, z, qw, qx, qy, qz = (float(number) for number in numbers.split(","))
    except ValueError:
        raise ConfigurationError(f"{option} {text}: give NAME=x,y,z,qw,qx,qy,qz, in mm.") from None
    # Of what is not finite the comparison is false.
    if not (math.isfinite(x + y + z) and abs(math.hypot(qw, qx, qy, qz) - 1.0) <= _UNIT):
        raise ConfigurationError(f"{option} {text}: its last four numbers are no quaternion of length 1.")
    return name.strip(), Pose((x, y, z), (qw, qx, qy, qz))
