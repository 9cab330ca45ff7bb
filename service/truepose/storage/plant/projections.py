"""What follows from a page of a cell's journal: robots, instruments, days and results that can be looked up.

Only what is on record counts, in the order of the chain, so that a plant that was set up anew comes to the
same. A day is that of the cell's clock; how far that was off is kept beside each result.
"""

import logging
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Table, select

from truepose.storage.plant.cells import newest_row
from truepose.storage.plant.records import (
    DAY,
    Branch,
    ClockSeen,
    CollectedLink,
    Document,
    day_of,
    document_in,
)
from truepose.storage.plant.result_projections import UNKNOWN_FORM, tell
from truepose.storage.plant.tables import (
    plant_days,
    plant_instruments,
    plant_results,
    plant_robots,
    plant_sessions,
)
from truepose.storage.record_insertion import add_row
from truepose.storage.rows import from_row, to_row

_LOG: Final = logging.getLogger(__name__)
_MEASURED: Final = "measured"


@dataclass(frozen=True, slots=True)
class _Known:
    """Of what a result is: the same for all that was made of it."""

    name: str = ""
    robot: str = ""
    robot_serial_number: str = ""
    instrument_serial_number: str = ""
    measured_on: str = ""


def project(
    connection: Connection, branch: Branch, page: Sequence[CollectedLink], clock: ClockSeen | None
) -> None:
    """Add what follows from a page, inside the caller's transaction."""
    seen = _Seen(connection, branch, None if clock is None else clock.offset_s)
    for link in page:
        if link.row is not None and link.record in _RECORDS:
            _look(seen, link, link.row)
            # After `_look`, which has added the result that this reads robot and day from.
            tell(connection, branch, link, link.row)
    seen.add_days()


def _look(seen: "_Seen", link: CollectedLink, row: Document) -> None:
    """Add what one record tells; one of a form that this version does not know is kept, and tells nothing."""
    try:
        _RECORDS[link.record](seen, link, row)
    # One record of a version that is newer than the plant must not end the collecting of its cell: the
    # journal has it, and a later version can tell it.
    except UNKNOWN_FORM as error:
        _LOG.warning("record %d of the %s tells nothing (%r)", link.record_id, link.record, error)


class _Seen:
    """What one page tells, added as it is read."""

    def __init__(self, connection: Connection, branch: Branch, offset_s: float | None) -> None:
        self._connection = connection
        self._branch = branch
        self._offset_s = offset_s
        self._days: Counter[tuple[int, str]] = Counter()

    def session(self, link: CollectedLink, row: Document) -> None:
        cell = document_in(row, "setup").get("cell", {})
        robot = str(cell.get("robot", {}).get("name", ""))
        known = _Known("", robot, str(cell.get("robot_serial_number", "")), _instrument(cell))
        self._keep_session(link.record_id, known)

    def entry(self, link: CollectedLink, row: Document) -> None:
        document = document_in(row, "document")
        if row.get("kind") == _MEASURED and row.get("reading_id") is None:
            self.reading(link, row)  # a length of a ballbar is a line of its own
        identity = document.get("identity") or {}
        # What is foreign measures nothing, and what is merely the same again tells nothing new.
        if identity.get("serial") and identity.get("finding") in {"first", "accepted"}:
            self._identified(int(row["session_id"]), identity)

    def reading(self, _link: CollectedLink, row: Document) -> None:
        self._days[int(row["session_id"]), day_of(row)] += 1

    def campaign(self, link: CollectedLink, row: Document) -> None:
        summary, sessions = document_in(row, "summary"), document_in(row, "session_ids")
        of_session = self._known_session(sessions[0]) if sessions else _Known()
        day = summary.get("measured_on") or (day_of(row) if sessions else "")
        known = replace(
            of_session,
            name=str(row["name"]),
            robot=str(row["robot"]),
            robot_serial_number=of_session.robot_serial_number or _stated(summary, "robot_serial_number"),
            instrument_serial_number=(
                of_session.instrument_serial_number or _stated(summary, "instrument_serial_number")
            ),
            measured_on=str(day),
        )
        self._result(link, "campaign", known)

    def diagnosis(self, link: CollectedLink, row: Document) -> None:
        known = self._known("campaign", row.get("campaign_id"))
        serial = str(row.get("robot_serial_number") or known.robot_serial_number)
        day = str(row.get("measured_at") or "")[:DAY] or known.measured_on
        self._result(link, "diagnosis", replace(known, robot_serial_number=serial, measured_on=day))

    def model(self, link: CollectedLink, row: Document) -> None:
        # A hand-down names no session: it is for the robot that stands in the cell.
        if row.get("handed_down_id") is not None:
            day = day_of(row)  # on which it was accepted for the robot of the cell
            self._result(link, "model", replace(self._newest_of(str(row["robot"])), measured_on=day))
            return
        of = ("diagnosis", row.get("diagnosis_id"))
        if row.get("identification_id") is not None:
            of = ("identification", row.get("identification_id"))
        self._result(link, "model", replace(self._known(*of), robot=str(row["robot"])))

    def report(self, link: CollectedLink, row: Document) -> None:
        kind, subject = str(row["kind"]), row.get("subject_id")
        known = self._known_session(subject) if kind == "session" else self._known(kind, subject)
        name = f"{kind} {subject}, revision {row['revision']} ({row['language']})"
        self._result(link, "report", replace(known, name=name))

    def closing(self, link: CollectedLink, row: Document) -> None:
        known = self._known_session(row.get("session_id"))
        closed = replace(known, name=str(row["closed_as"]), measured_on=day_of(row))
        self._result(link, "closing", closed)

    def made_of(self, kind: str, origin: str, link: CollectedLink, row: Document) -> None:
        """Add a result that has everything from another one."""
        self._result(link, kind, self._known(origin, row.get(f"{origin}_id")))

    def add_days(self) -> None:
        """Add how much was measured on which day; told last, when every session of the page is known."""
        for (session_id, day), readings in sorted(self._days.items()):
            known = replace(self._known_session(session_id), measured_on=day)
            about = {"branch_id": self._branch.id, "session_id": session_id, "readings": readings}
            add_row(self._connection, plant_days, **about, **to_row(known, plant_days))

    def _identified(self, session_id: int, identity: Document) -> None:
        known, serial = self._known_session(session_id), str(identity["serial"])
        if identity.get("device") == "robot":
            # The cell file comes before the controller: an arm's plate and its controller may have different
            # numbers (decision 0020).
            told = replace(known, robot_serial_number=known.robot_serial_number or serial)
        else:
            told = replace(known, instrument_serial_number=serial)
        if told != known:
            self._keep_session(session_id, told)

    def _keep_session(self, session_id: int, known: _Known) -> None:
        self._note(known)
        about = {"branch_id": self._branch.id, "session_id": session_id}
        add_row(self._connection, plant_sessions, **about, **to_row(known, plant_sessions))

    def _result(self, link: CollectedLink, kind: str, known: _Known) -> None:
        self._note(known)
        add_row(
            self._connection,
            plant_results,
            branch_id=self._branch.id,
            kind=kind,
            link=link.link,
            record_id=link.record_id,
            clock_offset_s=self._offset_s,
            **to_row(known, plant_results),
        )

    def _note(self, known: _Known) -> None:
        """Enter a robot and an instrument that were never seen before."""
        robot, instrument = known.robot_serial_number, known.instrument_serial_number
        if robot and not self._is_there(plant_robots, robot):
            add_row(self._connection, plant_robots, serial_number=robot, robot=known.robot)
        if instrument and not self._is_there(plant_instruments, instrument):
            add_row(self._connection, plant_instruments, serial_number=instrument)

    def _is_there(self, table: Table, serial_number: str) -> bool:
        query = select(table.c.id).where(table.c.serial_number == serial_number)
        return self._connection.scalar(query) is not None

    def _known(self, kind: str, record_id: Any) -> _Known:
        """Return what is known of an earlier result of the same chain."""
        here = (plant_results.c.kind == kind) & (plant_results.c.record_id == record_id)
        found = newest_row(self._connection, self._branch, plant_results, here, by_link=True)
        return _Known() if found is None else from_row(_Known, found)

    def _known_session(self, session_id: Any) -> _Known:
        return self._session_where(plant_sessions.c.session_id == session_id) or _Known()

    def _newest_of(self, robot: str) -> _Known:
        """Return of whom the newest session of a type of robot was: the robot that stands in the cell."""
        found = self._session_where(plant_sessions.c.robot == robot) or _Known(robot=robot)
        return replace(found, instrument_serial_number="")

    def _session_where(self, condition: ColumnElement[bool]) -> _Known | None:
        found = newest_row(self._connection, self._branch, plant_sessions, condition, by_link=False)
        return None if found is None else from_row(_Known, found, name="", measured_on="")


def _instrument(cell: Document) -> str:
    """Return the serial number that a cell's description gives to what measures in it."""
    devices = cell.get("devices", [])
    named = [device.get("serial_number", "") for device in devices if device.get("name") != "robot"]
    of_ballbar = ((cell.get("ballbar") or {}).get("instrument") or {}).get("serial_number", "")
    return next((str(serial) for serial in (*named, of_ballbar) if serial), "")


def _stated(summary: Document, name: str) -> str:
    """Return what an upload says; empty: nothing."""
    return str(summary.get(name) or "")


_RECORDS: Final[Mapping[str, Callable[[_Seen, CollectedLink, Document], None]]] = {
    "sessions": _Seen.session,
    "session_entries": _Seen.entry,
    "readings": _Seen.reading,
    "campaigns": _Seen.campaign,
    "identifications": lambda seen, link, row: seen.made_of("identification", "campaign", link, row),
    "validations": lambda seen, link, row: seen.made_of("validation", "campaign", link, row),
    "corrections": lambda seen, link, row: seen.made_of("correction", "model", link, row),
    "diagnoses": _Seen.diagnosis,
    "models": _Seen.model,
    "reports": _Seen.report,
    "closings": _Seen.closing,
}
