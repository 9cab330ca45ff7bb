"""Artefacts with their paper: what is certified, by whom, until when; and what a ballbar comes with."""

from dataclasses import dataclass, field
from typing import Final

REFERENCE_C: Final = 20.0  # at which lengths are certified, ISO 1


def length_at(length_mm: float, expansion_per_k: float, celsius: float) -> float:
    """Return the length of an artefact at a temperature [mm], from its length at 20 °C."""
    return length_mm * (1.0 + expansion_per_k * (celsius - REFERENCE_C))


@dataclass(frozen=True, slots=True)
class Artefact:
    """Paper of an artefact: what it is, and what says that its numbers hold."""

    name: str
    serial_number: str = ""
    certificate: str = ""
    certificate_expires: str = ""  # ISO date; empty where nobody said it


@dataclass(frozen=True, slots=True)
class Bars:
    """The ballbar made up with extension bars, and what the calibrator is certified to be for them."""

    nominal_mm: float
    calibrator_mm: float  # length of the calibrator at 20 degrees
    calibrator_u_mm: float
    bars_mm: tuple[float, ...]  # what the person screws on
    expansion_per_k: float | None = None  # of the calibrator; None: nobody said it


@dataclass(frozen=True, slots=True)
class BallbarKit:
    """A ballbar with its calibrator and fixtures, as the cell file describes them."""

    tool_bars: Bars = field(default_factory=lambda: Bars(150.0, 150.0, 0.0005, (50.0,)))
    base_bars: Bars = field(default_factory=lambda: Bars(300.0, 300.0, 0.0005, (150.0, 50.0)))
    range_mm: float = 1.0  # either way of the nominal length
    reading_u_mm: float = 0.00051  # QC20-W: 2 um at 95 %, thesis section 3.2
    uncertified_u_mm: float = 0.005  # of a ballbar whose certificate nobody has: nothing certain is known
    zero_u_mm: float = 0.0015  # of the zero by the snaps of the magnets since the last initialisation
    setup_u_mm: float = 0.01  # how well a clamped cup sits where the robot held the ball, per axis
    base_points: int = 3  # cups of the base fixture: 3, or 4
    instrument: Artefact = field(default_factory=lambda: Artefact("ballbar"))
    calibrator: Artefact = field(default_factory=lambda: Artefact("calibrator"))
