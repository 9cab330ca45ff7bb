"""Where the readings of a campaign come from: whether anything real was measured, when, on which robot."""

from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Label, case, cast, exists, func, select

from truepose.storage.column_types import WHOLE
from truepose.storage.dialects import entries_at, is_object_at, length_at, truth_at
from truepose.storage.tables import campaigns, readings, session_entries, sessions

_SIMULATED: Final = "$.cell.simulated"
_BY_A_NOTE: Final = "SIMULATED:"  # how older archives of this program say it


def simulated_session() -> Label[bool]:
    """Whether no robot and no instrument took part in a session of the query around it."""
    return is_simulated(sessions.c.setup).label("simulated")


def simulated_campaign() -> Label[bool]:
    """Whether a campaign of the query around it says of its readings that they are simulated.

    One made of sessions is if any of them is; an uploaded one if its own description says so.
    """
    of_sessions = length_at(campaigns.c.session_ids) > 0
    return case((of_sessions, _any_session_is()), else_=_its_description_says()).label("simulated")


def _any_session_is() -> ColumnElement[bool]:
    listed = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
    measured_in = sessions.alias("measured_in")
    return exists().where(measured_in.c.id == cast(listed.c.value, WHOLE), is_simulated(measured_in.c.setup))


def _its_description_says() -> ColumnElement[bool]:
    said = truth_at(campaigns.c.summary, "$.simulated")
    note = entries_at(campaigns.c.summary, "$.notes").table_valued("value", name="note")
    noted = exists().where(func.substr(note.c.value, 1, len(_BY_A_NOTE)) == _BY_A_NOTE)
    return case((said.is_(None), noted), else_=said)


def is_simulated(setup: Any) -> ColumnElement[bool]:
    """Whether a set-up is of a simulated cell."""
    return is_object_at(setup, _SIMULATED)


def in_cell(setup: Any, *, simulated: bool) -> ColumnElement[bool]:
    """Whether a set-up is of a simulated cell, or else of a real one."""
    return is_simulated(setup) if simulated else ~is_simulated(setup)


class Origin:
    """Of one campaign, inside the caller's transaction."""

    def __init__(self, connection: Connection, campaign_id: int) -> None:
        columns = (campaigns.c.recorded_at, campaigns.c.session_ids, campaigns.c.summary)
        stored = connection.execute(select(*columns).where(campaigns.c.id == campaign_id)).one()
        self._connection = connection
        self._stored_at, session_ids, self._summary = stored
        self._session_id = session_ids[0] if session_ids else None

    def measured_at(self) -> str:
        """Return the day that was stated, else when the session's last reading was stored; "": not known."""
        return str(self._summary.get("measured_on") or self._last_reading() or "")

    def _last_reading(self) -> str | None:
        if self._session_id is None:
            return None
        points = select(func.max(readings.c.recorded_at)).where(
            readings.c.session_id == self._session_id,
            readings.c.recorded_at <= self._stored_at,  # a running session goes on measuring
        )
        lengths = select(func.max(session_entries.c.recorded_at)).where(
            session_entries.c.session_id == self._session_id,
            session_entries.c.kind == "measured",
            session_entries.c.recorded_at <= self._stored_at,
        )
        last: str | None = self._connection.scalar(points) or self._connection.scalar(lengths)
        return last

    def robot_serial_number(self) -> str:
        """Return what the session's cell file said, else the campaign itself; "" where nobody did."""
        query = select(sessions.c.setup).where(sessions.c.id == self._session_id)
        setup = self._connection.scalar(query)
        told = self._summary if setup is None else setup["cell"]
        return str(told.get("robot_serial_number") or "")
