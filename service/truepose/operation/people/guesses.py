"""How often somebody may guess: ten times a minute, unless another limit is set.

A bucket holds five tokens and gets a new one every twelve seconds, so that no minute has more than ten. A
guess takes one before anything is looked at; who was right gets it back.
"""

import contextlib
import math
from collections import OrderedDict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from truepose.operation.people.errors import TooManyGuessesError

GUESSES: Final = 5  # at once, and as many more in the minute after them
_REMEMBERED: Final = 10_000  # the one that was idle longest is forgotten first, and is full by then


@dataclass(frozen=True, slots=True)
class Limit:
    """How many guesses there are at once, and how soon there is another one."""

    at_once: int = GUESSES
    refill_s: float = 60 / GUESSES


TEN_A_MINUTE: Final = Limit()


@dataclass(slots=True)
class _Bucket:
    tokens: float
    at_s: float


class Guesses:
    """Counts guesses by whom and from where; forgets who has long been quiet."""

    def __init__(self, elapsed_s: Callable[[], float], limit: Limit = TEN_A_MINUTE) -> None:
        self._elapsed_s = elapsed_s
        self._limit = limit
        self._buckets: OrderedDict[str, _Bucket] = OrderedDict()

    @contextlib.contextmanager
    def one(self, *names: str) -> Iterator[None]:
        """Take a guess as `take`, and give it back where the context ends without an error."""
        self.take(*names)
        yield
        self.give_back(*names)

    def take(self, *names: str) -> None:
        """Take a guess from the bucket of each name; raises TooManyGuessesError, then none is taken."""
        buckets = [self._bucket(name) for name in names]
        missing = 1 - min(bucket.tokens for bucket in buckets)
        if missing > 0:
            raise TooManyGuessesError(math.ceil(missing * self._limit.refill_s))
        for bucket in buckets:
            bucket.tokens -= 1

    def give_back(self, *names: str) -> None:
        """Give a guess back that was right."""
        for name in names:
            bucket = self._bucket(name)
            bucket.tokens = min(self._limit.at_once, bucket.tokens + 1)

    def _bucket(self, name: str) -> _Bucket:
        now_s = self._elapsed_s()
        bucket = self._buckets.setdefault(name, _Bucket(self._limit.at_once, now_s))
        self._buckets.move_to_end(name)
        gained = (now_s - bucket.at_s) / self._limit.refill_s
        bucket.tokens = min(self._limit.at_once, bucket.tokens + gained)
        bucket.at_s = now_s
        if len(self._buckets) > _REMEMBERED:
            self._buckets.popitem(last=False)
        return bucket
