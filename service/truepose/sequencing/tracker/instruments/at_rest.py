"""The arm at a stop, as a reading of it needs it."""

from dataclasses import dataclass

from truepose_drivers.api import JointReading


@dataclass(frozen=True, slots=True)
class AtRest:
    """Where the joints were read, and which way each of them came there."""

    joints: JointReading
    direction: tuple[int, ...]
