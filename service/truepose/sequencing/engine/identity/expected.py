"""Whether the device that answers is the one that is expected. Pure; both kinds of session ask here.

Expected is what the cell file says, as it is now, until the session has met a device; from then on it is
that device, or the one that a person accepted in its place. A device that tells no serial number is not
questioned: nobody could tell two of them apart. One that told a number before and says nothing now may be
another one; that is noted, and no certificate is claimed for what it measures.
"""

from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.measurement.identities import IdentityOf, IdentityTaken

_SAYS_NOTHING: Final = frozenset({"", "unknown"})
_LOST: Final = {
    "tracker": "the registration is done anew and readings before and after have a world frame each; "
    "certificate and checked scale of the other one do not hold for it",
    "ballbar": "the zero is read anew, the certificate does not hold for it, and its lengths count with the "
    "uncertainty of a ballbar without one",
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


def told(serial: str) -> str:
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
    serial, named = told(answered), expected.strip()
    if not serial:
        news = bool(known.serial) and not known.silent and known.foreign is None
        return IdentityTaken(device, "silent", "", known.serial) if news else None
    if known.serial:
        agreed = same_number(serial, known.serial) and (known.by_person or _fits(serial, named))
        wanted = known.serial if not same_number(serial, known.serial) else named
    else:
        agreed, wanted = _fits(serial, named), named
    if not agreed:
        asked = known.foreign is not None and same_number(serial, known.foreign.serial)
        return None if asked else IdentityTaken(device, "foreign", serial, wanted)
    if not known.serial:
        return IdentityTaken(device, "first", serial, named)
    if known.silent or known.foreign is not None:
        return IdentityTaken(device, "same", serial, known.serial)
    return None


def same_number(first: str, second: str) -> bool:
    """Whether two serial numbers are one: case and blanks around them do not count."""
    return first.strip().casefold() == second.strip().casefold()


def accepted(foreign: IdentityTaken, person: str) -> IdentityTaken:
    """Return the line that says that a person accepted a device in place of the expected one."""
    return replace(foreign, finding="accepted", person=person)


def sentence(taken: IdentityTaken) -> str:
    """Say what was found, what it means for the data and what to do."""
    name, serial = taken.device, taken.serial
    match taken.finding:
        case "first":
            return f"The {name} answers with serial number {serial}."
        case "same":
            return f"The {name} {serial} answers again."
        case "silent":
            return (
                f"The {name} does not tell its serial number any more; it was {taken.expected}. Whether it "
                "still is that one is not known, so its certificate is not claimed for what follows."
            )
        case "accepted":
            instead = f"in place of {taken.expected}"
            return f"{taken.person} accepted the {name} {serial} {instead}: {_LOST[taken.device]}."
        case "foreign" if taken.device == "robot":
            return (
                f"Another robot answers: serial number {serial} instead of {taken.expected}. Limits, model "
                f"and readings are those of {taken.expected}, so nothing moves. Connect that one again; or, "
                f"if {serial} is right, put it into the cell file, start the service anew and plan a session "
                "for it."
            )
        case "foreign":
            return (
                f"Another {name} answers: serial number {serial} instead of {taken.expected}. Nothing is "
                f"measured with it yet. Connect {taken.expected} again, or accept {serial} by name: then "
                f"{_LOST[taken.device]}."
            )


def _fits(serial: str, named: str) -> bool:
    return not named or same_number(serial, named)
