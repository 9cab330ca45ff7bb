"""What is stated beside a file of targets to be corrected.

A branch may be named as formats do. ABB's confdata ends with cfx (0 to 7): 4 for a wrist behind axis 1, 2 for
a wrist behind the lower arm, 1 for a negative joint 5. Behind axis 1 the lower arm leans backwards, so that a
wrist behind it is one with the elbow up. What FANUC's F and N, KUKA's S and Staubli's words mean for an arm
its table does not tell.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from truepose.domain.errors import ConfigurationError
from truepose.exchange.programs.program import Pose, ProgramOptions, TargetConventions
from truepose.kinematics.inverse import BRANCH_NAMES

_CONFDATA: Final = re.compile(r"-?\d+, -?\d+, -?\d+, ([0-7])")


def branch_of_words(words: str) -> int | None:
    """Return the branch, as `kinematics.inverse` numbers them; None where it is not understood."""
    if words in BRANCH_NAMES:
        return BRANCH_NAMES.index(words)
    found = _CONFDATA.fullmatch(words)
    if found is None:
        return None
    cfx = int(found[1])
    back, behind_lower_arm, negative = cfx >> 2, (cfx >> 1) & 1, cfx & 1
    return 4 * back + 2 * (behind_lower_arm ^ back) + negative


_UNIT: Final = 1e-6  # of the length of a quaternion


@dataclass(frozen=True, slots=True)
class CorrectionRequest:
    """How a file is meant; what does not concern its format does not matter."""

    meant: TargetConventions | None = (
        None  # None: a table in the world of the readings, a program in the base
    )
    defined: Mapping[str, Pose] = field(default_factory=dict)
    coupled: bool = False
    branch: int | None = None
    angles: str | None = None
    beside: Mapping[str, bytes] = field(default_factory=dict)
    as_written: bool = False  # also where another unit or frame fits better, or nearly all is out of reach
    most_targets: int | None = None  # more are refused; None: as many as are read

    @property
    def understood(self) -> ProgramOptions:
        """What of it concerns a program."""
        return ProgramOptions(self.meant or TargetConventions.BASE, self.defined, self.coupled, self.branch)


def branch_named(words: str, option: str) -> int:
    """Return the branch of such words as front/up/no flip; raises ConfigurationError."""
    found = branch_of_words(words)
    if found is None:
        raise ConfigurationError(
            f"{option} {words}: name a branch such as front/up/no flip or back/down/flip."
        )
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
        raise ConfigurationError(f"{option} {text}: its last four numbers are not a unit quaternion.")
    return name.strip(), Pose((x, y, z), (qw, qx, qy, qz))
