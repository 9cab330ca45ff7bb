"""Closing a session as calibrated: on certificates that hold, or by a named person for a stated reason."""

from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, date, datetime

from truepose.domain.cell.certificates import Closing, JudgedPaper, judged_papers
from truepose.domain.measurement.session import SessionState
from truepose.operation.certificates import papers_of_session
from truepose.operation.devices import Rack
from truepose.operation.errors import CertificateError
from truepose.operation.present_cell import PresentCell
from truepose.sequencing.engine.states import has_ended
from truepose.storage.errors import ConflictError
from truepose.storage.measurement.closings import ClosingRepository
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.records import SessionRecord
from truepose.words.catalogue import english


class ClosingDesk:
    """Closes sessions; the records say what each was closed as."""

    def __init__(
        self, sessions: SessionRepository, closings: ClosingRepository, rack: Rack, present: PresentCell
    ) -> None:
        self._sessions = sessions
        self._closings = closings
        self._rack = rack
        self._present = present

    async def certificates(self, session_id: int) -> tuple[JudgedPaper, ...]:
        """Return what the readings rest on, as it stood when the last was taken; raises NotFoundError."""
        record = await self._sessions.get(session_id)
        cell = (await self._sessions.setup(session_id)).cell
        identities = await self._sessions.identities(session_id)
        papers = papers_of_session(cell, identities, self._rack.used, by_bar=record.role == "ballbar")
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
        record = await self._sessions.get(wanted.session_id)
        person = self._present.require_person(wanted.person)
        _require_end(record, wanted)
        papers = await self.certificates(record.id)
        closing = replace(wanted, person=person, reason=wanted.reason.strip(), certificates=papers)
        if closing.overridden and not closing.reason:
            raise CertificateError(_refusal(closing.overridden))
        return await self._closings.keep(closing)


def _require_end(record: SessionRecord, wanted: Closing) -> None:
    if not has_ended(record.state):
        raise ConflictError("The session goes on; it is closed when it has ended.")
    if wanted.closed_as == "calibrated" and record.state is not SessionState.FINISHED:
        raise ConflictError(
            "The session ended before its plan did; it can be closed as not calibrated, or measured again."
        )


def _refusal(overridden: Iterable[JudgedPaper]) -> str:
    faults = " ".join(english(one.fault) for one in overridden)
    return (
        f"The session cannot be closed as calibrated. {faults} A named person may do so with a reason, "
        "which every report prints."
    )


def _last_day(record: SessionRecord) -> date:
    """Return the day on which the session came to where it is: its last reading is no younger."""
    return datetime.fromisoformat(record.state_since).astimezone(UTC).date()
