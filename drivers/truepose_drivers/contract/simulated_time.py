"""An event loop in which waiting takes no time: where nothing is ready, its clock jumps to the next timer.

For tests whose far ends live in memory. A socket, a process or a thread keeps the time of the wall, and
would be found silent.
"""

import asyncio
import selectors


class _JumpingSelector(selectors.DefaultSelector):
    """Lets time pass instead of waiting."""

    def __init__(self) -> None:
        super().__init__()
        self.passed_s = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:
            raise RuntimeError("the test waits for what nothing will bring about")
        events = super().select(0)
        if not events:
            self.passed_s += max(timeout, 0.0)
        return events


class SimulatedTimeLoop(asyncio.SelectorEventLoop):
    """Runs as fast as the machine allows, the same on a busy one as on an idle one."""

    def __init__(self) -> None:
        self._jumping = _JumpingSelector()
        super().__init__(self._jumping)

    def time(self) -> float:
        """Return the seconds that passed in it."""
        return self._jumping.passed_s
