"""What a study of the report is: trials, and the rows that their outcomes fill."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.planted.planting import Case
from tests.studies.diagnosis_report.trials import Trial
from tests.studies.report_command import informing
from truepose.reports.table_report import Row

Rows = tuple[Row, ...]

_ROW: Final = 1_000  # more campaigns than a row has


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is measured."""

    campaigns: int = 12  # a cell of the table
    undisturbed: int = 60  # campaigns without any effect, per size and kind of noise
    pairs: int = 36
    sizes: tuple[int, ...] = (50, 100, 200)
    first_seed: int = 1

    def seeds(self, n: int, row: int = 0) -> range:
        """Return the seeds of n campaigns of one row of a table.

        Rows share no cell: one odd draw of the noise would count in all of them.
        """
        first = self.first_seed + _ROW * row
        return range(first, first + n)


def wrong_names_note(outcomes: Sequence[Outcome]) -> str:
    """Return the names that nothing planted deserves."""
    names = tallies.wrong_names(outcomes)
    return f"Names that nothing planted deserves: {names}." if names else ""


@dataclass(frozen=True, slots=True)
class Study:
    """One section of the report."""

    key: str
    title: str
    trials: tuple[Trial, ...]
    rows: Callable[[Sequence[Outcome]], Rows]
    note: Callable[[Sequence[Outcome]], str] = wrong_names_note


def trial_of(cases: tuple[Case, ...], size: int, seed: int, factor: float = 1.0) -> Trial:
    """Return a trial of one or more cases; one that needs another robot or start decides for all."""
    special = next((case for case in cases if case.start is not None), cases[0])
    return Trial(
        label=" and ".join(case.label for case in cases),
        planted=tuple(case.planted(seed, size, factor) for case in cases),
        readings=size,
        seed=seed,
        scenario=special.scenario,
        start=special.start,
    )


def each_case(outcomes: Sequence[Outcome]) -> Rows:
    """Return a row for everything that was planted, without a target."""
    return tuple(_case_row(label, rows) for label, rows in tallies.by_label(outcomes).items())


def _case_row(label: str, outcomes: Sequence[Outcome]) -> Row:
    found = tallies.percent_by_size(outcomes, tallies.detected)
    right = tallies.percent_by_size(outcomes, tallies.named)
    doubted = tallies.percent_by_size(outcomes, tallies.doubted)
    sizes = " / ".join(str(size) for size in tallies.by_size(outcomes))
    return informing(f"{label} ({sizes})", f"detected {found}; named {right}; doubted {doubted}")
