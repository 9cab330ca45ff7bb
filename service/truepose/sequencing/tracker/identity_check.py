"""The devices of a tracker session: asked again and again, questioned where they differ."""

from truepose.domain.measurement.identities import IdentityOf, IdentityTaken
from truepose.domain.measurement.ledger import EntryKind
from truepose.sequencing.engine.identity.check import IdentityCheck
from truepose.sequencing.engine.identity.expected import accepted, same_number, sentence, told
from truepose.sequencing.errors import ForeignInstrumentError, ForeignRobotError, NotNowError
from truepose_drivers.api import Device, DeviceIdentity


class TrackerIdentityCheck(IdentityCheck):
    """Asks devices who they are and keeps what is new about it."""

    _permitted: tuple[str, str] | None = None  # serial number and person, until it is asked again

    @property
    def question(self) -> str | None:
        """What a person is asked about the tracker; None where nothing is."""
        return None if self.tracker_in_question is None else sentence(self.tracker_in_question)

    @property
    def tracker_in_question(self) -> IdentityTaken | None:
        """Another tracker than the expected one, until a person accepts it."""
        return self._foreign("tracker")

    def require_questioned(self, serial: str) -> None:
        """Raise NotNowError where nobody asks whether this tracker may measure; no number is none."""
        foreign = self.tracker_in_question
        if serial and (foreign is None or not same_number(serial, foreign.serial)):
            raise NotNowError(f"Nobody asks whether the tracker {serial} may measure; nothing was accepted.")

    def permit(self, serial: str, person: str) -> None:
        """Take the tracker of this serial number where it answers next: a person accepts it."""
        self._permitted = (serial, person) if serial else None

    async def meet(self, device: IdentityOf, link: Device) -> DeviceIdentity:
        """Ask a device who it is.

        Raises ForeignInstrumentError, ForeignRobotError, or what the driver raises; what was found is on
        disk by then.
        """
        identity = await link.identify()
        self.hear(device, identity)
        found = self.news(device, identity)
        permitted, self._permitted = self._permitted, None
        if found is not None:
            await self._note(found)
        foreign = self._foreign(device)
        if foreign is None:
            return identity
        if permitted is None or not same_number(permitted[0], told(identity.serial)):
            raise _refusal(foreign)
        await self._note(accepted(foreign, permitted[1]))
        return identity

    def _foreign(self, device: IdentityOf) -> IdentityTaken | None:
        return self._logbook.record.known(device).foreign

    async def _note(self, found: IdentityTaken) -> None:
        # who was met first is introduced anyway
        kind = EntryKind.CONTROL if found.finding == "first" else EntryKind.NOTED
        await self._logbook.write(kind, text=sentence(found), identity=found)


def _refusal(foreign: IdentityTaken) -> ForeignInstrumentError | ForeignRobotError:
    if foreign.device == "robot":
        return ForeignRobotError(sentence(foreign))
    return ForeignInstrumentError(foreign, sentence(foreign))
