"""Courses of a robot's life, drawn in a worker process: its error and its causes over the days."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from truepose.storage.plant.newest import ToldSeen

_BAND: Final = 1.96  # standard uncertainties of 95 %


@dataclass(frozen=True, slots=True)
class CoursesAsked:
    """What courses are drawn of, the oldest first."""

    told: tuple[ToldSeen, ...]
    tag: str  # language and units


@dataclass(frozen=True, slots=True)
class _Sight:
    day: str
    amplitude: float
    u: float


def drawn_courses(asked: CoursesAsked) -> str:
    """Return the courses of a robot's error and of each cause that a diagnosis named."""
    from truepose.reports.figures.curves.course import Course, course_figure
    from truepose.words.catalogue import catalogue

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


def _causes(told: Sequence[ToldSeen], words: Any) -> dict[tuple[str, str], list[_Sight]]:
    """Return what diagnoses saw of each cause whose amplitude and uncertainty they told."""
    from markupsafe import escape

    from truepose.domain.results.causes import Cause
    from truepose.reports.wording.causes import cause_words

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
