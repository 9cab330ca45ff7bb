"""What a night run leaves: JUnit XML for a build server, HTML for people, JSON for programs, a table."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from rich.console import Console
from rich.table import Table

from truepose.demo.command import RESULT
from truepose.demo.report import REPORT
from truepose.exchange.json_text import Json, render_json
from truepose.night.check import Check, NightCase, NightRequest
from truepose.night.history import FigureHistory, Night, NightFigure, course
from truepose.reports.table_report import Row, Section, Trend, Verdict, write_table_report
from truepose.version import __version__

JUNIT: Final = "junit.xml"
_TIME: Final = "time"  # the figure that every case has


@dataclass(frozen=True, slots=True)
class CaseOutcome:
    """What became of a case; `error` says why it could not be run to its end, and then nothing is judged."""

    case: NightCase
    checks: tuple[Check, ...]
    error: str | None
    wall_s: float

    @property
    def passed(self) -> bool:
        """Whether it was judged and reached every figure."""
        return self.error is None and all(check.passed for check in self.checks)


@dataclass(frozen=True, slots=True)
class NightRun:
    """A night as it went."""

    request: NightRequest
    began: datetime  # with its zone
    wall_s: float
    outcomes: tuple[CaseOutcome, ...]
    earlier: tuple[Night, ...] = ()  # the oldest first

    @property
    def nights(self) -> tuple[Night, ...]:
        """The nights before, and this one last."""
        return (*self.earlier, self.remembered)

    @property
    def remembered(self) -> Night:
        """What later nights are compared with."""
        figures = tuple(one for outcome in self.outcomes for one in _remembered(outcome))
        return Night(
            began=self.began,
            version=__version__,
            label=self.request.label,
            seed=self.request.seed,
            figures=figures,
        )

    def again(self, outcome: CaseOutcome) -> str:
        """Return the command that runs one case again."""
        return self.request.again(outcome.case.name)


def _remembered(outcome: CaseOutcome) -> Iterator[NightFigure]:
    name = outcome.case.name
    yield NightFigure(case=name, figure=_TIME, passed=outcome.error is None, value=outcome.wall_s)
    for one in outcome.checks:
        yield NightFigure(case=name, figure=one.figure, passed=one.passed, value=one.value)


def write_night(night: NightRun, out: Path) -> None:
    """Write junit.xml, report.html and result.json; raises UnwritableReportError or OSError."""
    root = junit(night)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(out / JUNIT, encoding="utf-8", xml_declaration=True)
    title = f"Nightly run of truepose {__version__}, seed {night.request.seed}"
    now = night.began.isoformat(timespec="seconds")
    write_table_report(out / REPORT, title, _sections(night), simulated=True, written_at=now)
    (out / RESULT).write_text(render_json(_document(night)) + "\n", encoding="utf-8")


def junit(night: NightRun) -> ElementTree.Element:
    """Return the JUnit document: a suite per case, a test case per figure.

    The dialect is that of Jenkins' xunit schema (junit-10.xsd), which build servers agree on.
    """
    root = ElementTree.Element("testsuites", {"name": "truepose nightly", "time": f"{night.wall_s:.3f}"})
    for outcome in night.outcomes:
        root.append(_suite(outcome, night))
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in root)))
    return root


def _suite(outcome: CaseOutcome, night: NightRun) -> ElementTree.Element:
    name = outcome.case.name
    failures = sum(not check.passed for check in outcome.checks)
    errors = int(outcome.error is not None)
    suite = ElementTree.Element(
        "testsuite",
        {
            "name": name,
            "tests": str(len(outcome.checks) + errors),
            "failures": str(failures),
            "errors": str(errors),
            "time": f"{outcome.wall_s:.3f}",
        },
    )
    properties = ElementTree.SubElement(suite, "properties")
    for key, value in (
        ("seed", night.request.seed),
        ("version", __version__),
        ("again", night.again(outcome)),
    ):
        ElementTree.SubElement(properties, "property", {"name": key, "value": str(value)})
    for check in outcome.checks:
        case = ElementTree.SubElement(suite, "testcase", {"classname": name, "name": check.figure})
        if not check.passed:
            said = f"{check.measured}; target: {check.target}"
            ElementTree.SubElement(case, "failure", {"message": said})
    if outcome.error is not None:
        case = ElementTree.SubElement(suite, "testcase", {"classname": name, "name": "run"})
        ElementTree.SubElement(case, "error", {"message": outcome.error})
    return suite


def _sections(night: NightRun) -> list[Section]:
    nights = night.nights
    return [_section(outcome, night, nights) for outcome in night.outcomes]


def _section(outcome: CaseOutcome, night: NightRun, nights: Sequence[Night]) -> Section:
    name = outcome.case.name
    note = outcome.case.note if outcome.passed else f"{outcome.case.note}. To repeat: {night.again(outcome)}"
    rows = tuple(
        Row(c.figure, c.target, c.measured, c.verdict, _trend(course(nights, name, c.figure)))
        for c in outcome.checks
    )
    if outcome.error is not None:
        rows = (Row("run", "completed", outcome.error, Verdict.NOT_MEASURED),)
    took = _trend(course(nights, name, _TIME))
    return Section(name, (*rows, Row(_TIME, "", f"{outcome.wall_s:.1f} s", Verdict.NO_TARGET, took)), note)


def _trend(seen: FigureHistory) -> Trend | None:
    if sum(one is not None for one in seen.measured) < 2:
        return None
    values = tuple(None if one is None else one.value for one in seen.measured)
    passed = tuple(None if one is None else one.passed for one in seen.measured)
    return Trend(values, passed, _said(seen))


def _said(seen: FigureHistory) -> str:
    if seen.first_bad is not None:
        return f"failing since the night of {seen.first_bad.name}"
    if seen.unusual and seen.usual is not None:
        return f"unusual: the median of earlier nights is {seen.usual[0]:.4g}"
    return ""


def _document(night: NightRun) -> dict[str, Json]:
    nights = night.nights
    return {
        "version": __version__,
        "label": night.request.label,
        "seed": night.request.seed,
        "began": night.began.isoformat(timespec="seconds"),
        "pass": all(outcome.passed for outcome in night.outcomes),
        "cases": [_case(outcome, night, nights) for outcome in night.outcomes],
        "wall_s": round(night.wall_s, 3),
    }


def _case(outcome: CaseOutcome, night: NightRun, nights: Sequence[Night]) -> dict[str, Json]:
    return {
        "name": outcome.case.name,
        "error": outcome.error,
        "checks": [
            _check(check, course(nights, outcome.case.name, check.figure)) for check in outcome.checks
        ],
        "again": night.again(outcome),
        "wall_s": round(outcome.wall_s, 3),
    }


def _check(check: Check, seen: FigureHistory) -> dict[str, Json]:
    return {
        "figure": check.figure,
        "target": check.target,
        "measured": check.measured,
        "pass": check.passed,
        "value": check.value,
        "first_bad_night": None if seen.first_bad is None else seen.first_bad.name,
        "unusual": seen.unusual,
    }


def print_night(night: NightRun, out: Path) -> None:
    """Print the figures on standard output, and what to look at."""
    table = Table(title="Nightly run on simulated cells")
    for name in ("case", "figure", "target", "measured", ""):
        table.add_column(name)
    sections = _sections(night)
    for section in sections:
        for number, row in enumerate(section.rows):
            name = section.title if number == 0 else ""
            table.add_row(name, row.figure, row.target, row.measured, row.verdict)
    console = Console(highlight=False)
    console.print(table, markup=False)
    for line in (*_noticed(sections), *_repeats(night)):
        console.print(line, soft_wrap=True, markup=False)
    console.print(f"JUnit, report and result are in {out}.", soft_wrap=True, markup=False)


def _noticed(sections: Sequence[Section]) -> Iterator[str]:
    for section in sections:
        for row in section.rows:
            if row.trend is not None and row.trend.sentence:
                yield f"{section.title}, {row.figure}: {row.trend.sentence}."


def _repeats(night: NightRun) -> Iterator[str]:
    for outcome in night.outcomes:
        if not outcome.passed:
            yield f"To repeat {outcome.case.name}: {night.again(outcome)}"
