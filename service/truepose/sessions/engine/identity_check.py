"""Whether the device that answers is the one that is expected. Pure; both kinds of session ask here.

Expected is what the cell file says, as it is now, until the session has met a device; from then on it is
that device, or the one that a person accepted in its place. A device that tells no serial number is not
questioned: nobody could tell two of them apart. One that told a number before and says nothing now may be
another one; that is noted, and no certificate is claimed for what it measures.
"""

from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.session import IdentityOf, IdentityTaken
from truepose.messages.message import Message, message

_SAYS_NOTHING: Final = frozenset({"", "unknown"})
# What is asked of a person who may accept another instrument, and what is kept once somebody did.
_ACCEPTABLE: Final = {"tracker": "session.identity.tracker", "ballbar": "session.identity.ballbar"}
_ACCEPTED: Final = {
    "tracker": "session.identity.accepted.tracker",
    "ballbar": "session.identity.accepted.ballbar",
}


@dataclass(frozen=True, slots=True)
class KnownDevice:
    """What a session knows of one of its devices; the default is that they have not met."""

    serial: str = ""  # of the one that it measures with
    first: str = ""  # of the one that it met first without anybody being asked
    by_person: bool = False  # a person accepted the one that it measures with
    silent: bool = False  # it has not told its number lately, although it did before
    foreign: IdentityTaken | None = None  # waits for a person

    def after(self, taken: IdentityTaken) -> "KnownDevice":
        """Return what is known after one more line of the session's record."""
        match taken.finding:
            case "first":
                return KnownDevice(taken.serial, self.first or taken.serial)
            case "accepted":
                return KnownDevice(taken.serial, self.first, by_person=True)
            case "same":
                return replace(self, silent=False, foreign=None)
            case "silent":
                return replace(self, silent=True, foreign=None)
            case "foreign":
                return replace(self, foreign=taken)


def reported_serial_number(serial: str) -> str:
    """Return the serial number that a device told, empty where it told none."""
    plain = serial.strip()
    return "" if plain.lower() in _SAYS_NOTHING else plain


def judge(device: IdentityOf, answered: str, expected: str, known: KnownDevice) -> IdentityTaken | None:
    """Return what an answer says that is new, None where it is what was to be expected.

    Parameters
    ----------
    device : str
    answered : str
        Serial number as the device tells it; "unknown" and nothing are no number.
    expected : str
        Serial number that the cell file names now; empty where it names none.
    known : KnownDevice
        From the session's record.
    """
    serial, named = reported_serial_number(answered), expected.strip()
    if not serial:
        # Silence is no answer to an open question: a foreign device that falls silent still waits for a
        # person.
        news = bool(known.serial) and not known.silent and known.foreign is None
        return IdentityTaken(device, "silent", "", known.serial) if news else None
    if known.serial:
        # A person's word stands against the cell file as it was then. Otherwise the file counts as it is now:
        # whoever corrects a serial number in it means the present session too.
        agreed = same_number(serial, known.serial) and (known.by_person or _fits(serial, named))
        wanted = known.serial if not same_number(serial, known.serial) else named
    else:
        agreed, wanted = _fits(serial, named), named
    if not agreed:
        # The question is put once; a third device is a question of its own.
        asked = known.foreign is not None and same_number(serial, known.foreign.serial)
        return None if asked else IdentityTaken(device, "foreign", serial, wanted)
    if not known.serial:
        return IdentityTaken(device, "first", serial, named)
    if known.silent or known.foreign is not None:
        return IdentityTaken(device, "same", serial, known.serial)
    return None


def same_number(first: str, second: str) -> bool:
    """Whether two serial numbers are one: case and blanks around them do not count."""
    # Numbers are typed off plates by hand.
    return first.strip().casefold() == second.strip().casefold()


def acceptance_entry(foreign: IdentityTaken, person: str) -> IdentityTaken:
    """Return the line that says that a person accepted a device in place of the expected one."""
    return replace(foreign, finding="accepted", person=person)


def sentence(taken: IdentityTaken) -> Message:
    """Say what was found, what it means for the data and what to do."""
    name, serial, expected = taken.device, taken.serial, taken.expected
    match taken.finding:
        case "first":
            return message("session.identity.first", device=name, serial=serial)
        case "same":
            return message("session.identity.same", device=name, serial=serial)
        case "silent":
            return message("session.identity.silent", device=name, expected=expected)
        case "accepted":
            return message(_ACCEPTED[name], person=taken.person or "", serial=serial, expected=expected)
        case "foreign" if name == "robot":
            return message("session.identity.robot", serial=serial, expected=expected)
        case "foreign":
            return message(_ACCEPTABLE[name], serial=serial, expected=expected)


def _fits(serial: str, named: str) -> bool:
    return not named or same_number(serial, named)
