"""How often it may be tried to show who somebody is: nobody guesses long, and a stranger locks nobody out.

A bucket holds five tokens and gets a new one every twelve seconds, so that no minute has more than ten. A
guess takes one before anything is looked at; who was right gets it back.

At the door, where passwords come in, an account has a limit for each address, an address one for all its
accounts, and an account a slow one for all addresses together. Where somebody signed in within a month only
the first holds: whatever others try elsewhere, they come in. At a tablet that is signed in the tablet has a
limit of its own, and so has each PIN there.
"""

import contextlib
import ipaddress
import math
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Final

from truepose.domain.people import Person, tidy_name
from truepose.people.errors import TooManyGuessesError
from truepose.people.register import Register
from truepose.people.steady_time import SteadyTime

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
        # No `finally`: whatever ends in an error has cost its guess, also where somebody closed the
        # connection before the answer.
        self.give_back(*names)

    def take(self, *names: str) -> None:
        """Take a guess from the bucket of each name; raises TooManyGuessesError, then none is taken."""
        buckets = {name: self._bucket(name) for name in names}
        missing = 1 - min(bucket.tokens for bucket in buckets.values())
        if missing > 0:
            raise TooManyGuessesError(math.ceil(missing * self._limit.refill_s))
        # Only now: whoever is turned away under ever new names would have all others forgotten.
        for name, bucket in buckets.items():
            bucket.tokens -= 1
            self._buckets[name] = bucket
        while len(self._buckets) > _REMEMBERED:
            self._buckets.popitem(last=False)

    def give_back(self, *names: str) -> None:
        """Give a guess back that was right."""
        for name in names:
            bucket = self._bucket(name)
            bucket.tokens = min(self._limit.at_once, bucket.tokens + 1)

    def _bucket(self, name: str) -> _Bucket:
        """Return the bucket of a name as it is now; a full one of whoever has taken nothing."""
        now_s = self._elapsed_s()
        bucket = self._buckets.get(name)
        if bucket is None:
            return _Bucket(self._limit.at_once, now_s)
        self._buckets.move_to_end(name)
        gained = (now_s - bucket.at_s) / self._limit.refill_s
        bucket.tokens = min(self._limit.at_once, bucket.tokens + gained)
        bucket.at_s = now_s
        return bucket


FROM_ALL_ADDRESSES: Final = Limit(at_once=30, refill_s=120.0)  # of one account: 750 a day
KNOWN_DAYS: Final = 30
WRONG_PINS: Final = 10  # in a row; after them only the password proves who it is
_NETWORK_BITS: Final = 64  # of an IPv6 address: whoever has one has all that begin alike


class Attempts:
    """Counts what is tried, at the door and at tablets."""

    def __init__(self, register: Register) -> None:
        elapsed_s = register.time.elapsed_s
        self.guesses = Guesses(elapsed_s)
        self.of_strangers = Guesses(elapsed_s, FROM_ALL_ADDRESSES)
        self.places = KnownPlaces(register.time)
        self.pins = WrongPins()
        for place in register.places:
            self.places.note(place.person_id, place.address, place.since)

    @contextlib.contextmanager
    def at_door(self, person: Person | None, name: str, address: str) -> Iterator[None]:
        """Count a password as wrong unless the context ends well; raises TooManyGuessesError."""
        # A name that nobody has is limited like any other: else the limit would tell which names there are.
        account = f"name {tidy_name(name).casefold()}" if person is None else f"account {person.id}"
        here = f"{account} at {address_block(address)}"
        if person is not None and self.places.include(person.id, address):
            with self.guesses.one(here):
                yield
            return
        with self.guesses.one(here, _at(address)), self.of_strangers.one(account):
            yield

    @contextlib.contextmanager
    def by_link(self, address: str) -> Iterator[None]:
        """Count a link as wrong unless the context ends well; raises TooManyGuessesError."""
        with self.guesses.one(_at(address)):
            yield

    @contextlib.contextmanager
    def at_tablet(self, tablet: int | None) -> Iterator[None]:
        """Count what is shown at a tablet as wrong unless the context ends well, as `at_door`."""
        with self.guesses.one(f"tablet {tablet}"):
            yield


class KnownPlaces:
    """The addresses at which somebody showed who they are, within a month."""

    def __init__(self, time: SteadyTime) -> None:
        self._time = time
        self._until: dict[tuple[int, str], str] = {}

    def note(self, person_id: int, address: str, since: str | None = None) -> None:
        """Note that somebody showed there who they are, now or at a time (UTC, ISO 8601)."""
        until = self._time.in_future(KNOWN_DAYS, since)
        if since is None:
            self._until = {at: end for at, end in self._until.items() if not self._time.is_over(end)}
        if not self._time.is_over(until):
            self._until[person_id, address_block(address)] = until

    def include(self, person_id: int, address: str) -> bool:
        """Whether somebody did so there within a month."""
        until = self._until.get((person_id, address_block(address)))
        return until is not None and not self._time.is_over(until)


class WrongPins:
    """PINs that were wrong in a row: of a person at a tablet, and at all those where they never stood."""

    def __init__(self) -> None:
        self._wrong: dict[tuple[int, int | None], int] = {}
        self._stood: set[tuple[int, int | None]] = set()

    def too_many(self, person_id: int, tablet: int | None) -> bool:
        """Whether a PIN counts there no more, also where it is right."""
        return self._wrong.get(self._count(person_id, tablet), 0) >= WRONG_PINS

    def note_wrong(self, person_id: int, tablet: int | None) -> None:
        """Count a PIN that was wrong."""
        count = self._count(person_id, tablet)
        self._wrong[count] = self._wrong.get(count, 0) + 1

    def note_stood(self, person_id: int, tablet: int | None) -> None:
        """Note that somebody has shown at a tablet who they are."""
        self._stood.add((person_id, tablet))

    def note_right(self, person_id: int, tablet: int | None) -> None:
        """Begin to count anew where a PIN was right."""
        self._wrong.pop(self._count(person_id, tablet), None)
        self.note_stood(person_id, tablet)

    def forgive(self, person_id: int) -> None:
        """Begin to count anew everywhere: a password was right."""
        self._wrong = {count: wrong for count, wrong in self._wrong.items() if count[0] != person_id}

    def forget_others(self, tablets: Collection[int]) -> None:
        """Forget the tablets at which nobody is signed in any more; guesses beside them stay counted."""
        self._stood = {count for count in self._stood if count[1] in tablets}
        self._wrong = {
            count: wrong for count, wrong in self._wrong.items() if count[1] is None or count[1] in tablets
        }

    def _count(self, person_id: int, tablet: int | None) -> tuple[int, int | None]:
        return person_id, tablet if (person_id, tablet) in self._stood else None


def address_block(address: str) -> str:
    """Return what of an address tells one network from another; a text that is no address as it is."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    mapped = getattr(found, "ipv4_mapped", None) or found
    if mapped.version == 4:
        return str(mapped)
    return str(ipaddress.ip_network((mapped, _NETWORK_BITS), strict=False))


def _at(address: str) -> str:
    return f"address {address_block(address)}"
