"""What one look at the service finds."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from truepose.storage.integrity.condition import Integrity


@dataclass(frozen=True, slots=True)
class DeviceLink:
    """How a device of the cell is reached."""

    connected: bool = False
    fault: str = ""  # of the last attempt; empty: none
    foreign: bool = False  # another device answered than the cell file names


@dataclass(frozen=True, slots=True)
class Clock:
    """The computer's clock: records have their order without it, and their dates from it."""

    moved_s: float = 0.0  # set since the start
    ahead_s: float | None = None  # of the newest record; negative: that is of a later time


@dataclass(frozen=True, slots=True)
class Copies:
    """Copies on a schedule."""

    every_s: float
    age_s: float | None = None  # of the newest; None: there is none
    fault: str = ""  # of the last attempt; empty: none


@dataclass(frozen=True, slots=True)
class Records:
    """The database."""

    readable: bool = True
    late: bool = False  # it did not answer the look; counts are those of an earlier one
    refused: str = ""  # why records are refused; empty: they are taken
    reserve_used: bool = False
    commit_s: float | None = None  # as it usually is of late
    free_bytes: int = 0
    size_bytes: int = 0
    integrity: Integrity = "not_checked"
    checked_share: float = 0.0
    damage: str = ""  # empty: none was found
    links: int = 0
    readings: int = 0
    server_doubts: tuple[str, ...] | None = None  # settings that are off on the server; None: a file


@dataclass(frozen=True, slots=True)
class State:
    """The service at one moment."""

    simulated: bool = False
    records: Records = field(default_factory=Records)
    sessions: Mapping[str, int] = field(default_factory=dict)  # by state
    jobs: Mapping[str, int] = field(default_factory=dict)  # by state
    job_seconds: Mapping[str, tuple[int, float]] = field(
        default_factory=dict
    )  # by kind: ended, and their work
    devices: Mapping[str, DeviceLink] = field(default_factory=dict)
    clock: Clock = field(default_factory=Clock)
    certificates: Mapping[str, int] = field(default_factory=dict)  # days left, by artefact
    uncertified: tuple[str, ...] = ()  # artefacts of which nobody said until when their certificate holds
    copies: Copies | None = None  # None: no schedule
    memory_bytes: int = 0
    lines_lost: int = 0  # of the log
