"""What traces a printed figure: conditions, certified lengths, devices, records, the page's edge.

Whatever is left out is printed as "not stated": a reader must see that nobody said it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.campaign import Stops
from truepose.domain.cell import Artefact, length_at
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, Text, message
from truepose.messages.units import ConvertibleNumber
from truepose.reports.rounding import format_rounded, millimetres, uncertainty_mm


@dataclass(frozen=True, slots=True)
class LengthOfDay:
    """A certified length, and the temperatures that were measured while it was used."""

    of: Text
    length_mm: float  # at 20 °C
    standard_uncertainty_mm: float
    expansion_per_k: float | None = None  # None: nobody said it
    temperature_c: tuple[float, float] | None = None  # lowest, highest; None: nothing was read


def length_sentence(length: LengthOfDay) -> Message:
    """Return the length at 20 °C and, where that is known, what it was then."""
    u = length.standard_uncertainty_mm
    at_20 = message("lengths.at_20", length=format_rounded(length.length_mm, u, "mm"), u=uncertainty_mm(u))
    if length.temperature_c is None:
        return message("lengths.no_temperature", at_20=at_20)
    low, high = length.temperature_c
    if length.expansion_per_k is None:
        return message("lengths.no_expansion", at_20=at_20, low_c=low, high_c=high)
    ends = [length_at(length.length_mm, length.expansion_per_k, celsius) for celsius in (low, high)]
    farthest = max((end - length.length_mm for end in ends), key=abs)
    return message(
        "lengths.then",
        at_20=at_20,
        low_c=low,
        high_c=high,
        shortest=format_rounded(min(ends), u, "mm"),
        longest=format_rounded(max(ends), u, "mm"),
        change=millimetres(farthest),
    )


NOT_STATED = "not_stated"  # a key of the catalogue


@dataclass(frozen=True, slots=True)
class Instrument:
    """A device that took part, as it identified itself, and its certificate in the owner's words."""

    role: str  # "laser tracker", "robot controller"
    manufacturer: str = ""
    model: str = ""
    serial_number: str = ""
    firmware: str = ""
    certificate: str = ""
    certificate_expires: str = ""  # ISO date


@dataclass(frozen=True, slots=True)
class Event:
    """Something that somebody did, for the audit trail."""

    when: str
    person: str
    what: Text


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
    speed_percent: float | None = None  # of the rated one
    settle_s: float | None = None
    measure_s: float | None = None
    temperature_c: tuple[float, float] | None = None  # lowest, highest of the air; None: from the readings
    instrument_temperature_c: tuple[float, float] | None = None  # at the ballbar
    part_temperature_c: float | None = None  # of arm and artefact
    lengths: tuple[LengthOfDay, ...] = ()  # certified, as they were then
    sessions: tuple[Period, ...] = ()
    two_face_mm: float | None = None  # half the difference between the faces
    registration_rms_mm: float | None = None
    scale: float | None = None  # certified over measured length; None: scale not verified
    scale_standard_uncertainty: float | None = None
    notes: tuple[str, ...] = ()
    number: str = ""  # of the report, with its revision
    measured_at: str = ""  # where no session says it
    closing: Text = ""  # as what its session was closed, by whom; "": it is of no session
    overridden: bool = False  # although a certificate did not hold
    events: tuple[Event, ...] = ()  # who did what, oldest first
    chain_head: str = ""  # of all records, when the report was made


def temperature_range(stops: Iterable[Stops]) -> tuple[float, float] | None:
    """Return the lowest and the highest temperature of stops; None where none was recorded."""
    columns = [one.temperature_c for one in stops if one.temperature_c is not None]
    known = np.concatenate([column[np.isfinite(column)] for column in columns]) if columns else np.zeros(0)
    return (float(known.min()), float(known.max())) if known.size else None


def condition_rows(conditions: ReportConditions, words: Catalogue = IN_ENGLISH) -> Iterator[tuple[str, str]]:
    """Yield (name, text) of every condition that is one line; "not stated" where it is absent."""
    say, unstated = words.say, words.say(NOT_STATED)
    yield say("conditions.load"), conditions.load or unstated
    yield say("conditions.warm_up"), conditions.warm_up or unstated
    yield say("conditions.approach"), conditions.approach or unstated
    yield say("conditions.tool_speed"), _quantity(conditions.tool_speed_mm_s, "mm/s", words)
    yield say("conditions.speed_percent"), _quantity(conditions.speed_percent, "%", words)
    yield say("conditions.orientation_speed"), _quantity(conditions.orientation_speed_rad_s, "rad/s", words)
    yield say("conditions.settling"), _quantity(conditions.settle_s, "s", words)
    yield say("conditions.duration"), _quantity(conditions.measure_s, "s", words)
    yield from _warmth(conditions, words)
    yield say("conditions.two_face"), _quantity(conditions.two_face_mm, "mm", words)
    yield say("conditions.registration"), _quantity(conditions.registration_rms_mm, "mm", words)
    yield say("conditions.scale"), words.spoken(scale_sentence(conditions))
    yield say("conditions.person"), conditions.person or unstated


def _warmth(conditions: ReportConditions, words: Catalogue) -> Iterator[tuple[str, str]]:
    """Yield temperatures, and what certified lengths were then."""
    yield words.say("conditions.temperature"), _range(conditions.temperature_c, words)
    if conditions.instrument_temperature_c is not None:
        at_bar = _range(conditions.instrument_temperature_c, words)
        yield words.say("conditions.temperature.ballbar"), at_bar
    yield words.say("conditions.temperature.part"), _quantity(conditions.part_temperature_c, "°C", words)
    for length in conditions.lengths:
        yield words.say("lengths.of", what=length.of), words.spoken(length_sentence(length))


def scale_sentence(conditions: ReportConditions) -> Message:
    """Return what is known of the instrument's scale."""
    if conditions.scale is None:
        return message("scale.not_verified")
    deviation, u = _signed(conditions.scale - 1.0), conditions.scale_standard_uncertainty
    if u is None:
        return message("scale.verified_without_uncertainty", deviation=deviation)
    return message("scale.verified", deviation=deviation, u=u)


def _signed(value: float) -> str:
    return ConvertibleNumber(lambda _: f"{'-' if value < 0.0 else '+'} {abs(value):.2g}")


def _quantity(value: float | None, unit: str, words: Catalogue) -> str:
    conversion = words.units.conversion(unit)
    return (
        words.say(NOT_STATED)
        if value is None
        else f"{conversion.formatted(value, '.3g')} {conversion.symbol}"
    )


def _range(lowest_highest_c: tuple[float, float] | None, words: Catalogue) -> str:
    if lowest_highest_c is None:
        return words.say(NOT_STATED)
    lowest_c, highest_c = lowest_highest_c
    return words.say("conditions.temperatures", lowest_c=lowest_c, highest_c=highest_c)


@dataclass(frozen=True, slots=True)
class PageMargins:
    """The four corners of a page; empty ones stay empty."""

    subject: str
    number: str = ""  # of the report, with its revision
    written_at: str = ""
    person: str = ""


def imprint_of(robot: str, conditions: ReportConditions, words: Catalogue) -> PageMargins:
    """Return the imprint of a report on a robot."""
    serial = conditions.robot_serial_number
    subject = words.say("report.robot.serial", robot=robot, serial=serial) if serial else robot
    return PageMargins(subject, conditions.number, conditions.written_at, conditions.person)


def css_string(text: str) -> str:
    """Return text of others as a string of a style sheet, which it cannot leave."""
    escaped = "".join(one if one.isalnum() or one == " " else f"\\{ord(one):x} " for one in text)
    return f'"{escaped}"'


@dataclass(frozen=True, slots=True)
class Audit:
    """Records behind a page, each with a SHA-256 that tells whether it is still the same."""

    session_id: int
    session_sha256: str  # of the newest link of its chain
    document: str  # address of the same figures as JSON
    document_sha256: str  # of what is sent from there
    model_id: int | None = None  # None: no model is judged
    model_sha256: str = ""  # of its file


def audit_rows(audit: Audit, words: Catalogue = IN_ENGLISH) -> Iterator[tuple[str, str, str]]:
    """Yield what each record is called, where it is, and its hash."""
    yield (
        words.say("audit.session", number=audit.session_id),
        f"/api/v1/sessions/{audit.session_id}",
        audit.session_sha256,
    )
    if audit.model_id is not None:
        file = f"/api/v1/models/{audit.model_id}/file"
        yield words.say("audit.model", number=audit.model_id), file, audit.model_sha256
    yield words.say("audit.document"), audit.document, audit.document_sha256


def with_temperature(conditions: ReportConditions, stops: Iterable[Stops]) -> ReportConditions:
    """Take the range of temperatures from the readings where nobody stated one."""
    if conditions.temperature_c is not None:
        return conditions
    return replace(conditions, temperature_c=temperature_range(stops))
