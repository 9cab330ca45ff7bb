"""What a night run leaves: JUnit XML for a build server, HTML for people, JSON for programs, a table."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from rich.console import Console
from rich.table import Table

from truepose.demo.night.cases import Check, NightCase
from truepose.demo.report import REPORT
from truepose.demo.result import RESULT
from truepose.exchange.json_text import Json, render_json
from truepose.reports import Row, Section, Verdict, write_table_report
from truepose.version import __version__

JUNIT: Final = "junit.xml"


@dataclass(frozen=True, slots=True)
class CaseOutcome:
    """What became of a case; `error` says why it could not be run to its end, and then nothing is judged."""

    case: NightCase
    checks: list[Check]
    error: str | None
    wall_s: float


def write_night(outcomes: Sequence[CaseOutcome], seed: int, wall_s: float, out: Path) -> None:
    """Write junit.xml, report.html and result.json; raises UnwritableReportError or OSError."""
    root = junit(outcomes, seed, wall_s)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(out / JUNIT, encoding="utf-8", xml_declaration=True)
    sections = [_section(outcome) for outcome in outcomes]
    title = f"Night run of truepose {__version__}, seed {seed}"
    now = datetime.now(UTC).isoformat(timespec="seconds")
    write_table_report(out / REPORT, title, sections, simulated=True, written_at=now)
    document = _document(outcomes, seed, wall_s)
    (out / RESULT).write_text(render_json(document) + "\n", encoding="utf-8")


def junit(outcomes: Sequence[CaseOutcome], seed: int, wall_s: float) -> ElementTree.Element:
    """Return the JUnit document: a suite per cell, a test case per figure.

    The dialect is that of Jenkins' xunit schema (junit-10.xsd), which build servers agree on.
    """
    root = ElementTree.Element("testsuites", {"name": "truepose nightly", "time": f"{wall_s:.3f}"})
    for outcome in outcomes:
        root.append(_suite(outcome, seed))
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in root)))
    return root


def _suite(outcome: CaseOutcome, seed: int) -> ElementTree.Element:
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
    for key, value in (("seed", seed), ("version", __version__)):
        ElementTree.SubElement(properties, "property", {"name": key, "value": str(value)})
    for check in outcome.checks:
        case = ElementTree.SubElement(suite, "testcase", {"classname": name, "name": check.figure})
        if not check.passed:
            said = f"{check.measured}; to be reached: {check.target}"
            ElementTree.SubElement(case, "failure", {"message": said})
    if outcome.error is not None:
        case = ElementTree.SubElement(suite, "testcase", {"classname": name, "name": "run"})
        ElementTree.SubElement(case, "error", {"message": outcome.error})
    return suite


def _section(outcome: CaseOutcome) -> Section:
    request = outcome.case.request
    note = (
        f"{request.calibration} calibration and {request.validation} validation configurations, "
        f"{outcome.wall_s:.0f} s"
    )
    if outcome.error is not None:
        missing = Row("run", "to its end", outcome.error, Verdict.NOT_MEASURED)
        return Section(outcome.case.name, (missing,), note)
    rows = tuple(Row(c.figure, c.target, c.measured, c.verdict) for c in outcome.checks)
    return Section(outcome.case.name, rows, note)


def _document(outcomes: Sequence[CaseOutcome], seed: int, wall_s: float) -> dict[str, Json]:
    return {
        "version": __version__,
        "seed": seed,
        "pass": all(outcome.error is None and _all_passed(outcome) for outcome in outcomes),
        "cases": [_case(outcome) for outcome in outcomes],
        "wall_s": round(wall_s, 3),
    }


def _case(outcome: CaseOutcome) -> dict[str, Json]:
    return {
        "name": outcome.case.name,
        "error": outcome.error,
        "checks": [
            {"figure": c.figure, "target": c.target, "measured": c.measured, "pass": c.passed}
            for c in outcome.checks
        ],
        "wall_s": round(outcome.wall_s, 3),
    }


def _all_passed(outcome: CaseOutcome) -> bool:
    return all(check.passed for check in outcome.checks)


def print_night(outcomes: Sequence[CaseOutcome], out: Path) -> None:
    """Print the figures on standard output."""
    table = Table(title="Night run on simulated cells")
    for name in ("cell", "figure", "to be reached", "measured", ""):
        table.add_column(name)
    for outcome in outcomes:
        for number, row in enumerate(_section(outcome).rows):
            name = outcome.case.name if number == 0 else ""
            table.add_row(name, row.figure, row.target, row.measured, row.verdict)
    console = Console(highlight=False)
    console.print(table, markup=False)
    console.print(f"JUnit, report and result are in {out}.", soft_wrap=True, markup=False)
