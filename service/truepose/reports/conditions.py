"""Under which conditions something was measured: what a report states beside its figures.

Whatever is left out is printed as "not stated": a reader must see that nobody said it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.cell import Artefact

NOT_STATED = "not stated"


@dataclass(frozen=True, slots=True)
class Instrument:
    """A device that took part, as it identified itself, and its certificate in the owner's words."""

    role: str  # "laser tracker", "robot controller"
    manufacturer: str = ""
    model: str = ""
    serial_number: str = ""
    firmware: str = ""
    certificate: str = ""


@dataclass(frozen=True, slots=True)
class Period:
    """When a session ran, in the wording of whoever recorded it (ISO 8601 by preference)."""

    name: str
    started: str = ""
    ended: str = ""


@dataclass(frozen=True, slots=True)
class ReportConditions:
    """Everything optional; None and "" mean that it was not stated."""

    simulated: bool = False  # as the record of the readings says
    instruments: tuple[Instrument, ...] = ()
    artefacts: tuple[Artefact, ...] = ()
    robot_serial_number: str = ""
    person: str = ""
    written_at: str = ""
    load: str = ""
    warm_up: str = ""
    approach: str = ""
    tool_speed_mm_s: float | None = None
    orientation_speed_rad_s: float | None = None
    settle_s: float | None = None
    measure_s: float | None = None
    temperature_c: tuple[float, float] | None = None  # lowest, highest of the air; None: from the readings
    sessions: tuple[Period, ...] = ()
    two_face_mm: float | None = None  # half the difference between the faces
    registration_rms_mm: float | None = None
    scale: float | None = None  # certified over measured length; None: scale not verified
    scale_standard_uncertainty: float | None = None
    notes: tuple[str, ...] = ()


def condition_rows(conditions: ReportConditions) -> Iterator[tuple[str, str]]:
    """Yield (name, text) of every condition that is one line; "not stated" where it is absent."""
    yield "Load", conditions.load or NOT_STATED
    yield "Warm-up", conditions.warm_up or NOT_STATED
    yield "Approach", conditions.approach or NOT_STATED
    yield "Speed of the tool", _quantity(conditions.tool_speed_mm_s, "mm/s")
    yield "Speed of reorientation", _quantity(conditions.orientation_speed_rad_s, "rad/s")
    yield "Settling before a reading", _quantity(conditions.settle_s, "s")
    yield "Duration of a reading", _quantity(conditions.measure_s, "s")
    yield "Temperature of the air", _range(conditions.temperature_c)
    yield "Two-face error (half the difference)", _quantity(conditions.two_face_mm, "mm")
    yield "Registration in the world, RMS of the fixed nests", _quantity(conditions.registration_rms_mm, "mm")
    yield "Scale of the instrument", scale_sentence(conditions)
    yield "Measured by", conditions.person or NOT_STATED


def scale_sentence(conditions: ReportConditions) -> str:
    """Return what is known of the instrument's scale."""
    if conditions.scale is None:
        return "scale not verified: no certified length was measured"
    deviation = f"certified over measured length is 1 {_signed(conditions.scale - 1.0)}"
    if conditions.scale_standard_uncertainty is None:
        return f"verified on a certified length: {deviation}, uncertainty {NOT_STATED}"
    return f"verified on a certified length: {deviation}, u = {conditions.scale_standard_uncertainty:.2g}"


def _signed(value: float) -> str:
    return f"{'-' if value < 0.0 else '+'} {abs(value):.2g}"


def _quantity(value: float | None, unit: str) -> str:
    return NOT_STATED if value is None else f"{value:.3g} {unit}"


def _range(lowest_highest_c: tuple[float, float] | None) -> str:
    if lowest_highest_c is None:
        return NOT_STATED
    lowest, highest = lowest_highest_c
    return f"{lowest:.1f} to {highest:.1f} °C"
