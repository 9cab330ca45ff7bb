"""What became of each case, as a table of drivers and cases."""

from collections.abc import Sequence
from dataclasses import dataclass


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
