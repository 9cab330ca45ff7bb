"""The devices of a tracker session as it knows them: asked again and again, questioned where they differ."""

from truepose.domain.identities import IdentityOf, IdentityTaken
from truepose.domain.session import Registration
from truepose.sequencing.engine.identities import accepted, judge, known_device, same_number, sentence, told
from truepose.sequencing.engine.identity_check import Expected
from truepose.sequencing.errors import ForeignInstrumentError, ForeignRobotError, NotNowError
from truepose.sequencing.tracker.journal import SessionJournal
from truepose_drivers.api import Device, DeviceIdentity


class DeviceIdentities:
    """Asks devices who they are and keeps what is new about it."""

    def __init__(
        self, expected: Expected, journal: SessionJournal, record: tuple[IdentityTaken, ...] = ()
    ) -> None:
        self._expected = expected
        self._journal = journal
        devices: tuple[IdentityOf, ...] = ("tracker", "robot")
        self._known = {device: known_device(device, record) for device in devices}
        self._permitted: tuple[str, str] | None = None  # serial number and person, until it is asked again

    def vouch_for(self, registration: Registration) -> bool:
        """Whether a registration is of the tracker that the session measures with."""
        tracker = self._known["tracker"]
        if tracker.foreign is not None:
            return False
        if registration.instrument_serial and tracker.serial:
            return same_number(registration.instrument_serial, tracker.serial)
        return not tracker.by_person

    @property
    def question(self) -> str | None:
        """What a person is asked about the tracker; None where nothing is."""
        foreign = self._known["tracker"].foreign
        return None if foreign is None else sentence(foreign)

    def require_questioned(self, serial: str) -> None:
        """Raise NotNowError where nobody asks whether this tracker may measure; no number is none."""
        foreign = self._known["tracker"].foreign
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
        self._expected.heard(device, identity)
        serial = told(identity.serial)
        found = judge(device, serial, self._expected.serials.get(device, ""), self._known[device])
        permitted, self._permitted = self._permitted, None
        if found is not None:
            await self._keep(found)
        foreign = self._known[device].foreign
        if foreign is None:
            return identity
        if permitted is None or not same_number(permitted[0], serial):
            raise _refusal(foreign)
        await self._keep(accepted(foreign, permitted[1]))
        return identity

    async def _keep(self, found: IdentityTaken) -> None:
        await self._journal.identified(found)
        if found.finding != "first":  # who was met first is introduced anyway
            await self._journal.noted(sentence(found))
        self._known[found.device] = self._known[found.device].after(found)


def _refusal(foreign: IdentityTaken) -> ForeignInstrumentError | ForeignRobotError:
    if foreign.device == "robot":
        return ForeignRobotError(sentence(foreign))
    return ForeignInstrumentError(foreign, sentence(foreign))
