"""The authority over a session: two may look, one acts.

It belongs to a person at a tablet, not to a connection, and ends where it is not renewed. A page renews it
while it is open; after a reload the same person at the same tablet has it still.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from truepose.messages.message import message
from truepose.people.errors import SomebodyElseActsError
from truepose.people.register import Caller

# A page renews it every few seconds. It does not hang on a connection: a reload, or a tablet that fell, would
# keep everybody out (decision 0057).
LEASE_S: Final = 15.0


@dataclass(frozen=True, slots=True)
class Lease:
    """Who acts in a session, and until when if nothing renews it."""

    person: str
    tablet: int | None
    tablet_name: str
    until_s: float

    def is_of(self, caller: Caller) -> bool:
        """Whether it is this person's, at this tablet."""
        return (self.person, self.tablet) == (caller.name, caller.tablet)


class Leases:
    """Who acts in which session; after a restart nobody does, until somebody acts."""

    def __init__(self, elapsed_s: Callable[[], float]) -> None:
        self._elapsed_s = elapsed_s
        self._leases: dict[int, Lease] = {}

    def of(self, session_id: int) -> Lease | None:
        """Return who acts in a session; None: whoever acts next."""
        found = self._leases.get(session_id)
        return found if found is not None and found.until_s > self._elapsed_s() else None

    def left_s(self, lease: Lease) -> float:
        """Return how long a lease lasts if nothing renews it."""
        return max(0.0, lease.until_s - self._elapsed_s())

    def claim(self, session_id: int, caller: Caller) -> Lease:
        """Have the authority, or go on having it; raises SomebodyElseActsError."""
        held = self.of(session_id)
        if held is not None and not held.is_of(caller):
            where = "people.acts_elsewhere" if held.tablet_name else "people.acts"
            raise SomebodyElseActsError(
                message(
                    where,
                    person=held.person,
                    session=session_id,
                    tablet=held.tablet_name,
                    seconds=math.ceil(self.left_s(held)),
                )
            )
        return self.take_over(session_id, caller)

    def take_over(self, session_id: int, caller: Caller) -> Lease:
        """Have the authority, whoever had it."""
        until_s = self._elapsed_s() + LEASE_S
        lease = Lease(caller.name, caller.tablet, caller.tablet_name, until_s)
        self._leases = {number: held for number in self._leases if (held := self.of(number)) is not None}
        self._leases[session_id] = lease
        return lease

    def give_up(self, session_id: int, caller: Caller) -> None:
        """Leave the authority to whoever acts next, where it is this person's."""
        held = self.of(session_id)
        if held is not None and held.is_of(caller):
            del self._leases[session_id]
