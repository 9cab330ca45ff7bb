"""The devices of a ballbar session as its ledger knows them; what is new about them becomes a line of it."""

from truepose.domain.ballbar import EntryKind
from truepose.domain.identities import IdentityOf, IdentityTaken
from truepose.sequencing.ballbar.logbook import Book
from truepose.sequencing.engine.identities import judge, sentence
from truepose.sequencing.tracker.identity_check import Expected
from truepose_drivers.api import DeviceIdentity


class Acquaintances:
    """Judges who answered; its caller lets one append at a time."""

    def __init__(self, expected: Expected, book: Book) -> None:
        self._expected = expected
        self._book = book

    def news(self, device: IdentityOf, identity: DeviceIdentity | None) -> IdentityTaken | None:
        """Return what an answer says that is new, None where it says nothing new or nobody answered yet."""
        if identity is None:
            return None
        now = self._book.situation
        known = now.robot if device == "robot" else now.ballbar
        return judge(device, identity.serial, self._expected.serials.get(device, ""), known)

    def hear(self, device: IdentityOf, identity: DeviceIdentity) -> None:
        """Tell whoever wants to know what a device answered."""
        self._expected.heard(device, identity)

    async def keep(self, taken: IdentityTaken) -> None:
        """Put what was found on record."""
        await self._book.append(EntryKind.CONTROL, text=sentence(taken), identity=taken)
