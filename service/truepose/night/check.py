"""What a night is asked for, and what every case of it gives: figures against their targets."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from truepose.demo.progress import RunProgress
from truepose.reports.table_report import Verdict


@dataclass(frozen=True, slots=True)
class NightRequest:
    """What is run, and where it is left."""

    out: Path  # created where needed
    seed: int  # of what a night draws
    label: str = ""  # by which the night is found again, e.g. a commit
    only: tuple[str, ...] = ()  # names of cases; none: all of them
    benches: tuple[str, ...] = ()  # of drivers, beside those that installed packages bring

    def again(self, case: str) -> str:
        """Return the command that runs one case again."""
        benches = "".join(f" --bench {bench}" for bench in self.benches)
        return f"truepose nightly --seed {self.seed} --case {case}{benches} --out night-again"


def seed_of_the_day() -> int:
    """Return the seed of a night that asks for none: every day draws something else."""
    return datetime.now(UTC).date().toordinal()


@dataclass(frozen=True, slots=True)
class Check:
    """A figure, its target and what was measured, in words; the value is what nights are compared by."""

    figure: str
    target: str
    measured: str
    passed: bool
    value: float | None = None  # in the unit of `measured`; None: nothing that grows or shrinks

    @property
    def verdict(self) -> Verdict:
        """What the figure says of its target."""
        return Verdict.PASSED if self.passed else Verdict.FAILED


class NightCase(Protocol):
    """One thing that a night tries."""

    @property
    def name(self) -> str:
        """By which it is asked for again, and compared with other nights."""
        ...

    @property
    def note(self) -> str:
        """What is tried, in a sentence's words."""
        ...

    def run(self, folder: Path, progress: RunProgress) -> Sequence[Check]:
        """Try it and leave everything in `folder`; raises TrueposeError where it cannot be judged."""
        ...


def at_most(figure: str, value: float, limit: float, unit: str, digits: int = 4) -> Check:
    """Return the check that a figure is no larger than its limit."""
    return Check(figure, f"<= {limit:g} {unit}", f"{value:.{digits}f} {unit}", value <= limit, value)


def none_of(figure: str, wrong: Sequence[str]) -> Check:
    """Return the check that nothing was wrong; it says what was first."""
    said = f"{len(wrong)}: {wrong[0]}" if wrong else "none"
    return Check(figure, "none", said, not wrong, float(len(wrong)))


def convergence_check(document: Mapping[str, Any]) -> Check:
    """Return the check that there is a model at all, of the document of an identification."""
    status = str(document["status"])
    return Check("identification", "converged", status, status == "converged")
