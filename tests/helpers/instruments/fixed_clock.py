"""The clock of a cell in which no time passes."""

from dataclasses import dataclass


@dataclass(frozen=True)
class FixedClock:
    """Tells one time, and fails a driver that sleeps in cell time: only sessions do."""

    time_s: float = 12.5

    async def now_s(self) -> float:
        return self.time_s

    async def sleep(self, duration_s: float) -> None:
        raise AssertionError(f"a driver sleeps {duration_s} s in cell time")
