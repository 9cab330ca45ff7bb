"""What a command makes the server do, one after the other; sockets and waiting are the server's business."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.leica_emscon.protocol import FromServer


@dataclass(frozen=True, slots=True)
class Wait:
    """The head is at work for that long."""

    duration_s: float
    stoppable: bool = False  # takes wall time at any pace: only a client's request ends what waits so


@dataclass(frozen=True, slots=True)
class CutShort:
    """The link breaks in the middle of this packet."""

    packet: FromServer


@dataclass(frozen=True, slots=True)
class HangUp:
    """The server closes the connection."""


Step: TypeAlias = FromServer | Wait | CutShort | HangUp
Steps: TypeAlias = Iterator[Step]
