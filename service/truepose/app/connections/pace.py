"""Whether something moves fast enough."""


class Pace:
    """So many bytes a second after a grace, on average since it began."""

    def __init__(self, bytes_per_s: float, grace_s: float) -> None:
        self._bytes_per_s = bytes_per_s
        self._grace_s = grace_s
        self._moved = 0
        self.amount = 0  # what there is to move, where that is known
        self.since_s = 0.0

    def begin(self, now_s: float, amount: int = 0) -> None:
        """Count anew from now on."""
        self.since_s, self.amount, self._moved = now_s, amount, 0

    def move(self, n_bytes: int) -> None:
        """Count what has moved."""
        self._moved += n_bytes

    def lasted(self, now_s: float) -> float:
        """Return since how long it goes on [s]."""
        return now_s - self.since_s

    def is_behind(self, now_s: float) -> bool:
        """Return whether less has moved than should have, without any grace."""
        return self._moved < self.lasted(now_s) * self._bytes_per_s

    def too_slow(self, now_s: float, moved: int | None = None) -> bool:
        """Return whether less has moved than should have."""
        late_s = self.lasted(now_s) - self._grace_s
        return late_s > 0 and (self._moved if moved is None else moved) < late_s * self._bytes_per_s
