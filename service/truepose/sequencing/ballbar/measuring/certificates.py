"""Whose certificate holds for a length: certificates follow the serial number of the instrument."""

from dataclasses import dataclass

from truepose.domain.cell.artefacts import Artefact
from truepose.sequencing.engine.identity.expected import KnownDevice, same_number


@dataclass(frozen=True, slots=True)
class Papers:
    """Serial number and certificate that a length is kept with."""

    serial: str  # empty where it is not known
    certificate: str
    certificate_expires: str
    hold: bool  # what the cell file says of the ballbar is said of this one


def papers_of(told: str, known: KnownDevice, owner: Artefact, device_serial: str) -> Papers:
    """Return what holds for the ballbar that has just told its serial number.

    Parameters
    ----------
    told : str
        Empty where it tells none.
    known : KnownDevice
        Of the session with its ballbar.
    owner : Artefact
        The ballbar that the cell file describes.
    device_serial : str
        Number that the cell file names for the device, where that is another one than the ballbar's: a
        cable's, a counter's.
    """
    if not told:
        silent = bool(known.serial)  # it did tell one before, so this may be another
        return Papers("", "", "", hold=False) if silent else _of(owner, owner.serial_number)
    if device_serial and same_number(told, device_serial):
        return _of(owner, owner.serial_number or told)
    if same_number(told, owner.serial_number or known.first):
        return _of(owner, told)
    return Papers(told, "", "", hold=False)


def _of(owner: Artefact, serial: str) -> Papers:
    return Papers(serial, owner.certificate, owner.certificate_expires, hold=True)
