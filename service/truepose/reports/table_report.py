"""Figures against their targets as an HTML page: the night run and the accuracy report."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from truepose.reports.pages import rendered
from truepose.reports.paper import write_report_text


class Verdict(StrEnum):
    """What a figure says of its target; a figure that was not measured never passed."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_MEASURED = "not measured"
    NO_TARGET = "for information"


@dataclass(frozen=True, slots=True)
class Trend:
    """A figure through earlier runs, the oldest first; None where a run did not measure it."""

    values: tuple[float | None, ...]
    passed: tuple[bool | None, ...]
    sentence: str = ""  # what is said of it, if anything

    @property
    def dots(self) -> tuple[tuple[float, float, bool], ...]:
        """Return across (0 to 100), down (0 to 20) and whether it was reached, of each run that has a dot."""
        known = [value for value in self.values if value is not None]
        low, high = min(known, default=0.0), max(known, default=0.0)
        each = zip(range(len(self.values)), self.values, self.passed, strict=True)
        return tuple(
            (_share(number, 0, len(self.values) - 1) * 100.0, _down(value, low, high), passed)
            for number, value, passed in each
            if passed is not None
        )


def _down(value: float | None, low: float, high: float) -> float:
    return 10.0 if value is None else 20.0 * (1.0 - _share(value, low, high))


def _share(value: float, low: float, high: float) -> float:
    """Return how far a value is between two; the middle where they are one."""
    return (value - low) / (high - low) if high > low else 0.5


@dataclass(frozen=True, slots=True)
class Row:
    """A figure, its target and what was measured, as they shall be read."""

    figure: str
    target: str
    measured: str
    verdict: Verdict
    trend: Trend | None = None


@dataclass(frozen=True, slots=True)
class Section:
    """Rows that belong together."""

    title: str
    rows: tuple[Row, ...]
    note: str = ""

    @property
    def has_trends(self) -> bool:
        """Whether a figure was measured before."""
        return any(row.trend is not None for row in self.rows)


def write_table_report(
    path: Path, title: str, sections: Sequence[Section], *, simulated: bool = False, written_at: str = ""
) -> None:
    """Write figures against targets as one self-contained HTML file.

    Parameters
    ----------
    path : Path
        Replaced where it exists; its folder is made.
    title : str
    sections : sequence of Section
    simulated : bool
        Whether the figures come from simulated devices; the page says so on top.
    written_at : str
        Date and time in the writer's wording.

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    """
    page = rendered(
        "table.html",
        title=title,
        sections=tuple(sections),
        simulated=simulated,
        written_at=written_at,
        sentence=verdict_sentence(sections),
        good=_all_passed(sections),
    )
    write_report_text(path, page)


def verdict_sentence(sections: Sequence[Section]) -> str:
    """Return the result of all rows with a target in one sentence."""
    verdicts = _verdicts(sections)
    if not verdicts:
        return "No figure has a target."
    if _all_passed(sections):
        return f"All {len(verdicts)} figures meet their targets."
    failed, missing = verdicts.count(Verdict.FAILED), verdicts.count(Verdict.NOT_MEASURED)
    return f"Of {len(verdicts)} figures with a target: {failed} failed, {missing} not measured."


def _verdicts(sections: Sequence[Section]) -> list[Verdict]:
    every = (row.verdict for section in sections for row in section.rows)
    return [verdict for verdict in every if verdict is not Verdict.NO_TARGET]


def _all_passed(sections: Sequence[Section]) -> bool:
    verdicts = _verdicts(sections)
    return bool(verdicts) and all(verdict is Verdict.PASSED for verdict in verdicts)
