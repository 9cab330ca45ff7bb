"""Figures of a fleet and of a robot's life, drawn in a worker process: hence the imports inside functions."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from truepose.analysis.fleets.campaign_summaries import CollectedCampaign
from truepose.storage.caches import to_bytes
from truepose.storage.plant.overview import ResultFacts

if TYPE_CHECKING:
    from truepose.messages.catalogue import Catalogue


LIMIT_MM: Final = 0.1  # of a change, where nobody asks for another


@dataclass(frozen=True, slots=True)
class FleetDrawing:
    """What a page is drawn of."""

    robot: str  # the type
    campaigns: tuple[CollectedCampaign, ...]
    limit_mm: float
    tag: str  # language and units
    computed_at: str


def draw_fleet(asked: FleetDrawing) -> bytes:
    """Return what the comparison foretells at the plant's limit, a line, and behind it the content.

    Raises ConfigurationError where the robots cannot be compared.
    """
    from datetime import date

    from truepose.analysis.fleets.campaigns import Entry, summary_from
    from truepose.analysis.fleets.comparison import LeftOut, fleet_found, foretold
    from truepose.exchange.tables.files import Stated
    from truepose.messages.catalogue import catalogue
    from truepose.reports.fleet import FleetReport

    entries, left_out = [], []
    for one in asked.campaigns:
        seen = one.seen
        name = f"{seen.cell} {seen.record_id} {seen.name}"
        if not one.told:
            left_out.append(LeftOut(name, one.why))
            continue
        day = date.fromisoformat(seen.measured_on)
        stated = Stated(seen.robot_serial_number, seen.instrument_serial_number, day)
        entries.append(Entry(name, stated, summary_from(one.told)))
    found = fleet_found(entries, left_out, asked.robot)
    without = tuple((one.campaign, one.why) for one in found.left_out)
    report = FleetReport(found.account, asked.robot, asked.limit_mm, without, language=asked.tag)
    words = catalogue(asked.tag)
    computed = words.say("fleet.computed", moment=asked.computed_at)
    parts = (
        _simulated(words) if found.simulated else "",
        report.content(),
        f'<p class="muted">{computed}</p>',
    )
    newest = max(one.seen.id for one in asked.campaigns)
    told = foretold(found.account, asked.robot, newest, LIMIT_MM, asked.computed_at)
    return b"\n".join((to_bytes(told), "".join(parts).encode()))


def _simulated(words: "Catalogue") -> str:
    said = words.say("page.simulated"), words.say("page.simulated.meaning")
    return f'<p role="note"><strong>{said[0]}</strong> {said[1]}</p>'


_BAND: Final = 1.96  # standard uncertainties of 95 %


@dataclass(frozen=True, slots=True)
class CoursesDrawing:
    """What courses are drawn of, the oldest first."""

    told: tuple[ResultFacts, ...]
    tag: str  # language and units


@dataclass(frozen=True, slots=True)
class _Sight:
    day: str
    amplitude: float
    u: float


def draw_courses(asked: CoursesDrawing) -> str:
    """Return the courses of a robot's error and of each cause that a diagnosis named."""
    from truepose.messages.catalogue import catalogue
    from truepose.reports.figures.over_days import Course, course_figure

    words = catalogue(asked.tag)
    parts = []
    errors = [(one.measured_on, one.figure_mm) for one in asked.told if one.kind == "identification"]
    known = [(day, mean) for day, mean in errors if mean is not None]
    if known:
        mean_mm = _array([mean for _, mean in known])
        course = Course("", mean_mm, mean_mm, mean_mm)
        title, days = words.say("over_time.error.short"), [day for day, _ in known]
        picture = course_figure(days, [course], title, "mm", "error", title, words)
        parts.append((words.say("fleet.error"), picture, words.say("fleet.error.meaning")))
    for number, ((name, unit), sights) in enumerate(_causes(asked.told, words).items()):
        value = _array([one.amplitude for one in sights])
        u = _array([_BAND * one.u for one in sights])
        days = [one.day for one in sights]
        amplitude = words.say("over_time.amplitude")
        course = Course(name, value, value - u, value + u)
        picture = course_figure(days, [course], amplitude, unit, f"cause{number}", name, words)
        parts.append((name, picture, words.say("over_time.amplitude.band")))
    return "".join(
        f'<h3>{title}</h3><figure><div class="picture">{picture}</div>'
        f"<figcaption>{said}</figcaption></figure>"
        for title, picture, said in parts
    )


def _causes(told: Sequence[ResultFacts], words: Any) -> dict[tuple[str, str], list[_Sight]]:
    """Return what diagnoses saw of each cause whose amplitude and uncertainty they told."""
    from markupsafe import escape

    from truepose.domain.diagnosis import Cause
    from truepose.reports.cause_words import cause_words

    found: defaultdict[tuple[str, str], list[_Sight]] = defaultdict(list)
    for one in told:
        for cause in one.document.get("causes", ()) if one.kind == "diagnosis" else ():
            u = cause["amplitude_standard_uncertainty"]
            if cause["amplitude"] is None or u is None:
                continue
            name = str(escape(cause_words(Cause(cause["effect"], cause["subject"]), words)))
            found[name, cause["unit"]].append(_Sight(one.measured_on, cause["amplitude"], u))
    return found


def _array(values: Sequence[float]) -> Any:
    import numpy as np

    return np.array(values, dtype=float)
