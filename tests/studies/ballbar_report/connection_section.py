"""Wrong connections as a table."""

from typing import Final

from tests.studies.ballbar_report.connections import SlipCounts
from tests.studies.report_command import informing, target_row
from truepose.reports.table_report import Row, Section, Verdict

_NAMED: Final = {"same": 0.99, "single": 0.95, "exchanged": 0.99}
_LEGS: Final = 6


def connection_section(counts: SlipCounts) -> Section:
    """Return how often slips are named, and right connections questioned."""
    n, against = counts.stops, counts.silent_against_evidence
    rows = (
        _at_least("same pair read twice, named", _NAMED["same"], counts.same_named, n),
        _at_least(
            "single wrong connection, named", _NAMED["single"], counts.single_named, n - counts.single_nowhere
        ),
        _at_least("exchanged pair, both named", _NAMED["exchanged"], counts.exchanged_named, n),
        target_row("stored against the evidence", "0", str(against), not against),
        _told("exchanged pair, the first named when it is read", counts.exchanged_named_at_once, n),
        _told("slips stored without a question", counts.silent, 3 * n - counts.single_nowhere),
        _told("... likelier by the readings than what was asked", counts.silent_likelier, counts.silent),
        _told("right connections that are questioned", counts.questions, _LEGS * n),
        _told("right poses that are to be measured again", counts.poses_refused, n),
    )
    note = (
        "After a pre-calibration: six legs aimed at ±0.7 mm in steps of 0.28 mm, the worst of them foreseen "
        "with 0.06 mm, errors correlated as the forecast says. A single slip is to a pair within range that "
        "was not read yet. Against the evidence: silently, though the readings speak for the slip by more "
        "than slips are rare (1 in 100)."
    )
    return Section(f"Wrong connections, {n} stops", rows, note)


def _at_least(figure: str, limit: float, named: int, of: int) -> Row:
    target = f">= {100 * limit:g} %"
    if not of:
        return Row(figure, target, "no stop", Verdict.NOT_MEASURED)
    return target_row(figure, target, _share(named, of), named >= limit * of)


def _told(figure: str, count: int, of: int) -> Row:
    return informing(figure, _share(count, of) if of else f"{count} of 0")


def _share(count: int, of: int) -> str:
    return f"{100.0 * count / of:.2f} % ({count} of {of})"
