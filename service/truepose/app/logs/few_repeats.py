"""Few lines for much of the same: who asks a thousand times must not fill a disk with a thousand lines."""

import logging
import time
from collections.abc import Callable
from typing import Final

from truepose.web.observation.requests import LOGGER as REQUESTS

_BURST: Final = 5
_WINDOW_S: Final = 10.0
_MOST_KEYS: Final = 1000
# What these write, strangers cause, each time with other addresses and numbers in it.
_OF_STRANGERS: Final = ("uvicorn", "asyncio", REQUESTS)
_MOST_REQUESTS: Final = 500  # of each level; what a shop with fifty tablets asks in that time


class FewRepeats(logging.Filter):
    """Lets a few lines of a kind through in ten seconds; the next one after that says how many there were."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._seen: dict[tuple[str, int, str], tuple[float, int]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a line is written; adds to it how many were not."""
        text = "" if record.name.startswith(_OF_STRANGERS) else record.getMessage()
        key = (record.name, record.levelno, text)
        now_s = self._clock()
        burst = _MOST_REQUESTS if record.name == REQUESTS else _BURST
        began_s, count = self._seen.get(key, (now_s, 0))
        if now_s - began_s >= _WINDOW_S:
            if count > burst:
                record.msg = f"{record.getMessage()} (and {count - burst} lines like it, not written)"
                record.args = ()
            began_s, count = now_s, 0
        if len(self._seen) >= _MOST_KEYS:
            self._seen.clear()
        self._seen[key] = (began_s, count + 1)
        return count < burst
