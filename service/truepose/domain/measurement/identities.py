"""Which instrument answered: what a session keeps of it, apart from its readings."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

IdentityOf: TypeAlias = Literal["tracker", "robot", "ballbar"]
Finding: TypeAlias = Literal[
    "first",  # the session measures with this one; nobody had to be asked
    "same",  # it answers again, after it had said nothing or another one was there
    "silent",  # it told its serial number before and does not any more
    "foreign",  # not the one that is expected; nothing is measured before a person has accepted it
    "accepted",  # a person accepted it in place of the one that was expected
]


@dataclass(frozen=True, slots=True)
class IdentityTaken:
    """What a device answered when it was asked who it is, where that says anything new."""

    device: IdentityOf
    finding: Finding
    serial: str  # as it answered; empty: it does not say
    expected: str = ""  # of the cell file, or of the session so far; empty: nothing was
    person: str | None = None  # who accepted it
