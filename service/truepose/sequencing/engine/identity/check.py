"""The devices of a session as its ledger knows them; what is new about them becomes a line of it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from truepose.domain.measurement.identities import IdentityOf, IdentityTaken
from truepose.domain.measurement.ledger import EntryKind
from truepose.sequencing.engine.identity.expected import judge, sentence
from truepose.sequencing.engine.logbook import Logbook
from truepose_drivers.api import DeviceIdentity

Heard: TypeAlias = Callable[[IdentityOf, DeviceIdentity], None]


def _nobody_listens(device: IdentityOf, identity: DeviceIdentity) -> None:
    pass


@dataclass(frozen=True, slots=True)
class Expected:
    """What the cell file says now of its devices, and who wants to hear what they answer."""

    serials: Mapping[IdentityOf, str] = field(default_factory=dict)  # what it does not name may be any
    heard: Heard = _nobody_listens


class IdentityCheck:
    """Judges who answered; who keeps what was found lets one append at a time."""

    def __init__(self, expected: Expected, logbook: Logbook[Any]) -> None:
        self._expected = expected
        self._logbook = logbook

    def news(self, device: IdentityOf, identity: DeviceIdentity | None) -> IdentityTaken | None:
        """Return what an answer says that is new, None where it says nothing new or nobody answered yet."""
        if identity is None:
            return None
        known = self._logbook.record.known(device)
        return judge(device, identity.serial, self._expected.serials.get(device, ""), known)

    def hear(self, device: IdentityOf, identity: DeviceIdentity) -> None:
        """Tell whoever wants to know what a device answered."""
        self._expected.heard(device, identity)

    async def keep(self, taken: IdentityTaken) -> None:
        """Put what was found on record."""
        await self._logbook.append(EntryKind.CONTROL, text=sentence(taken), identity=taken)
