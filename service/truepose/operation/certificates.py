"""Which certificates the readings of a session rest on: they follow the serial numbers (decision 0020)."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from truepose.domain.cell.artefacts import Artefact
from truepose.domain.cell.certificates import Paper
from truepose.domain.cell.description import Cell, DeviceEntry
from truepose.domain.measurement.identities import IdentityOf, IdentityTaken
from truepose.sequencing.engine.identity.expected import same_number

_ROLES: Final[Mapping[IdentityOf, str]] = {"tracker": "laser tracker", "ballbar": "ballbar"}


def papers_of_session(
    cell: Cell, identities: Iterable[IdentityTaken], used: Mapping[IdentityOf, str], *, by_bar: bool
) -> Iterator[Paper]:
    """Yield what is to be shown for each instrument that measured, and for the artefacts it measured with.

    Parameters
    ----------
    cell : Cell
        As the session was planned in.
    identities : iterable of IdentityTaken
        In the order in which the devices answered.
    used : mapping
        Name of the entry of the cell file that is a session's tracker, or ballbar.
    by_bar : bool
        The ballbar measured.
    """
    answered = dict.fromkeys((one.device, one.serial) for one in identities if one.device in _ROLES)
    met: set[IdentityOf] = set()
    for device, serial in answered:
        yield _of_instrument(cell, device, serial, "" if device in met else used.get(device, ""))
        met.add(device)
    yield from map(_of_artefact, _artefacts(cell, by_bar=by_bar))


def papers_of_cell(cell: Cell) -> Iterator[Paper]:
    """Yield every certificate that a cell file states, to warn before one ends."""
    for entry in cell.devices:
        if entry.certificate:
            yield _of_entry(entry.name, entry.serial_number, entry)
    bar = () if cell.ballbar is None else (cell.ballbar.instrument, cell.ballbar.calibrator)
    for artefact in (*bar, cell.tool, cell.world):
        if artefact is not None and artefact.certificate:
            yield _of_artefact(artefact)


def _of_instrument(cell: Cell, device: IdentityOf, serial: str, first: str) -> Paper:
    """Return the paper of a serial number; `first` names the entry that the first to answer may claim."""
    if device == "ballbar" and cell.ballbar is not None and _claims(cell.ballbar.instrument, serial, first):
        return Paper(
            _ROLES[device],
            serial,
            cell.ballbar.instrument.certificate,
            cell.ballbar.instrument.certificate_expires,
        )
    entry = next((one for one in cell.devices if _claims(one, serial, first == one.name)), None)
    return Paper(_ROLES[device], serial) if entry is None else _of_entry(_ROLES[device], serial, entry)


def _claims(stated: Artefact | DeviceEntry, serial: str, first: object) -> bool:
    if not stated.certificate:
        return False
    if stated.serial_number:
        return bool(serial) and same_number(stated.serial_number, serial)
    return bool(first)


def _of_entry(of: str, serial: str, entry: DeviceEntry) -> Paper:
    return Paper(of, serial, entry.certificate, entry.certificate_expires)


def _of_artefact(artefact: Artefact) -> Paper:
    return Paper(artefact.name, artefact.serial_number, artefact.certificate, artefact.certificate_expires)


def _artefacts(cell: Cell, *, by_bar: bool) -> Iterator[Artefact]:
    """Yield what carries numbers that the readings rest on; nests that are identified rest on no paper."""
    if by_bar and cell.ballbar is not None:
        yield cell.ballbar.calibrator
    if cell.tool is not None and any(nest.centre_mm is not None for nest in cell.nests):
        yield cell.tool
    if cell.world is not None and not by_bar:
        yield cell.world
