"""What a night is asked for."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path


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
