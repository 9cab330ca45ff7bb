"""Closing a session as calibrated: on certificates that hold, or by a named person for a stated reason."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from typing import Any, Final

from truepose.domain.cell import Artefact, Cell, Closing, DeviceEntry, JudgedPaper, Paper, judged_papers
from truepose.domain.session import IdentityOf, IdentityTaken, SessionState
from truepose.messages.message import Message, message, together
from truepose.sessions.cell import CurrentCell
from truepose.sessions.devices import DeviceRegistry
from truepose.sessions.engine.identity_check import same_number
from truepose.sessions.engine.states import has_ended
from truepose.sessions.errors import CertificateError
from truepose.sessions.kinds import SessionKind
from truepose.storage.errors import ConflictError
from truepose.storage.ledger.added_stops import ClosingRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import SessionRecord

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
    # Each instrument once, in the order in which it first answered.
    answered = dict.fromkeys((one.device, one.serial) for one in identities if one.device in _ROLES)
    met: set[IdentityOf] = set()
    for device, serial in answered:
        # An entry of the cell file that names no number is claimed by the first to answer; the next one is
        # another instrument, and has no paper (decision 0020).
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


@dataclass(frozen=True, slots=True)
class ClosingService:
    """Closes sessions; the records say what each was closed as."""

    sessions: SessionRepository
    closings: ClosingRepository
    rack: DeviceRegistry
    present: CurrentCell
    kind_of: Callable[[SessionRecord], SessionKind[Any]]

    async def certificates(self, session_id: int) -> tuple[JudgedPaper, ...]:
        """Return what the readings rest on, as of the day on which the session ended; raises NotFoundError.

        Of one under way it is the day on which it came to the state that it is in.
        """
        record = await self.sessions.get(session_id)
        cell = (await self.sessions.setup(session_id)).cell
        identities = await self.sessions.identities(session_id)
        by_bar = self.kind_of(record).by_calibrator
        papers = papers_of_session(cell, identities, self.rack.used, by_bar=by_bar)
        return judged_papers(papers, _last_day(record))

    async def close(self, wanted: Closing) -> Closing:
        """Keep what a session is closed as, and return it as it is kept.

        Raises
        ------
        NotFoundError
        ConflictError
            It goes on, has not finished, or is closed already.
        CertificateError
            One did not hold when the readings were taken, and no reason is given.
        PersonUnknownError, PersonUnreadableError
        """
        record = await self.sessions.get(wanted.session_id)
        person = self.present.require_person(wanted.person)
        _require_end(record, wanted)
        # Kept with the closing, which then says by itself on what it rested.
        papers = await self.certificates(record.id)
        closing = replace(wanted, person=person, reason=wanted.reason.strip(), certificates=papers)
        if closing.overridden and not closing.reason:
            raise CertificateError(_refusal(closing.overridden))
        return await self.closings.keep(closing)


def _require_end(record: SessionRecord, wanted: Closing) -> None:
    if not has_ended(record.state):
        raise ConflictError(message("session.refused.close_before_end"))
    if wanted.closed_as == "calibrated" and record.state is not SessionState.FINISHED:
        raise ConflictError(message("session.refused.close_unfinished"))


def _refusal(overridden: Iterable[JudgedPaper]) -> Message:
    faults = together(*(one.fault for one in overridden))
    return message("session.refused.close_without_certificates", faults=faults)


def _last_day(record: SessionRecord) -> date:
    """Return the day on which the session came to where it is: its last reading is no younger."""
    return datetime.fromisoformat(record.state_since).astimezone(UTC).date()
