"""The suite in pytest: its options, its cases for every driver, and the table at the end."""

from collections.abc import Sequence
from dataclasses import dataclass

import pytest

from truepose_drivers.contract.bench import NewBench, find_benches
from truepose_drivers.contract.cases import CASES
from truepose_drivers.contract.hostile import QUICK_INPUTS
from truepose_drivers.contract.link_recovery import FAULTS_EACH
from truepose_drivers.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class Row:
    """What became of one case asked of one driver."""

    driver: str
    case: str
    kept: str  # yes, NO or - where it was not asked
    reason: str = ""  # why it was not asked


def table(rows: Sequence[Row]) -> list[str]:
    """Return a line a case with a column a driver, then the reasons; nothing where nothing was asked."""
    if not rows:
        return []
    drivers = sorted({row.driver for row in rows})
    cases = list(dict.fromkeys(row.case for row in rows))
    kept = {(row.driver, row.case): row.kept for row in rows}
    numbered = [f"{number:2d} {driver}" for number, driver in enumerate(drivers, start=1)]
    width = max(map(len, cases))
    head = " " * width + "".join(f"{number:4d}" for number in range(1, len(drivers) + 1))
    lines = [
        f"{case:{width}s}" + "".join(f"{kept.get((driver, case), ''):>4s}" for driver in drivers)
        for case in cases
    ]
    return ["", *numbered, "", head, *lines, *_reasons(rows)]


def _reasons(rows: Sequence[Row]) -> list[str]:
    by_reason: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row.reason:
            by_reason.setdefault((row.driver, row.reason), []).append(row.case)
    lines = [f"{driver}: {reason} ({', '.join(cases)})" for (driver, reason), cases in by_reason.items()]
    return ["", "Not asked:", *sorted(lines)] if lines else []


_BENCHES = pytest.StashKey[dict[str, NewBench]]()
_MARKS = {"passed": "yes", "failed": "NO", "error": "NO", "skipped": "-"}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Say which drivers are asked, and for how long."""
    group = parser.getgroup("truepose", "the contract of truepose's drivers")
    group.addoption("--driver", action="append", help="test this driver, may be repeated; default: all")
    group.addoption(
        "--bench",
        action="append",
        default=[],
        help="MODULE:NAME of a bench, or of a list of them, in addition to those of installed packages",
    )
    group.addoption(
        "--fuzz-inputs",
        type=int,
        default=QUICK_INPUTS,
        help="hostile bytes to each codec",
    )
    group.addoption(
        "--hostile-answers",
        type=int,
        default=QUICK_INPUTS,
        help="answers spoiled, of each driver",
    )
    group.addoption("--link-faults", type=int, default=FAULTS_EACH, help="faults of each driver's link")


def pytest_configure(config: pytest.Config) -> None:
    """Find the benches."""
    try:
        config.stash[_BENCHES] = find_benches(config.getoption("bench"), config.getoption("driver"))
    except ConfigurationError as error:
        raise pytest.UsageError(str(error)) from error


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Ask every case of every driver."""
    benches = metafunc.config.stash[_BENCHES]
    metafunc.parametrize(("driver", "new_bench"), list(benches.items()), ids=list(benches))
    if "case" in metafunc.fixturenames:
        metafunc.parametrize("case", CASES, ids=[case.name for case in CASES])


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which driver keeps which case, and why a case is not asked."""
    rows = [
        Row(**named, kept=mark, reason=_reason(report))
        for outcome, mark in _MARKS.items()
        for report in terminalreporter.stats.get(outcome, [])
        if {"driver", "case"} == (named := dict(report.user_properties)).keys()
    ]
    for line in table(rows):
        terminalreporter.write_line(line)


def _reason(report: pytest.TestReport) -> str:
    if not report.skipped or not isinstance(report.longrepr, tuple):
        return ""
    return str(report.longrepr[2]).removeprefix("Skipped: ")
