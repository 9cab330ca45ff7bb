"""How far a session is and how many minutes are left, learnt from its own pace in cell time."""

from dataclasses import dataclass

from truepose.domain.session import Progress


@dataclass(slots=True)
class Pace:
    """Counts configurations and adds up the cell time in which the session was not waiting for a person."""

    planned: int
    done: int = 0
    skipped: int = 0
    elapsed_s: float = 0.0
    doing: str = "waiting for a person"
    _last_s: float | None = None  # None while waiting
    _stops: int = 0  # configurations of this run
    _before_s: float | None = None  # elapsed when the first configuration of this run began

    def tick(self, now_s: float) -> None:
        """Add the time since the last tick."""
        if self._last_s is not None:
            self.elapsed_s += max(0.0, now_s - self._last_s)
        self._last_s = now_s

    def hold(self) -> None:
        """Stop counting time until the next tick."""
        self._last_s = None

    def begin_stop(self) -> None:
        """Remember when the first configuration began; what came before it says nothing of the pace."""
        if self._before_s is None:
            self._before_s = self.elapsed_s

    def end_stop(self, *, measured: bool) -> None:
        """Count a configuration as done or skipped."""
        self.done += measured
        self.skipped += not measured
        self._stops += 1

    def progress(self) -> Progress:
        """Return the present count; no time left is stated before the first configuration has been."""
        left = self.planned - self.done - self.skipped
        remaining_s = None
        if self._stops and self._before_s is not None:
            remaining_s = left * (self.elapsed_s - self._before_s) / self._stops
        return Progress(self.done, self.skipped, self.planned, self.elapsed_s, remaining_s, self.doing)
