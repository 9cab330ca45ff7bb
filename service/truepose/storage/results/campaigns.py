"""Campaigns, as arrays and as the zip that was uploaded, and where their readings come from."""

from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, Label, Select, case, cast, exists, false, func, select

from truepose.storage.database import Database
from truepose.storage.engine.dialects import WHOLE, entries_at, is_object_at, length_at, truth_at
from truepose.storage.queries import NumberedRecords
from truepose.storage.record_insertion import add_event, add_row, answered_number, once
from truepose.storage.records import CampaignRecord, CampaignSummary, RequestKey
from truepose.storage.rows import from_row, to_row
from truepose.storage.tables import campaigns, readings, session_entries, sessions

_SIMULATED: Final = "$.cell.simulated"


def simulated_session() -> Label[bool]:
    """Whether no robot and no instrument took part in a session of the query around it."""
    return is_simulated(sessions.c.setup).label("simulated")


def simulated_campaign() -> Label[bool]:
    """Whether a campaign of the query around it says of its readings that they are simulated.

    One made of sessions is if any of them is; an uploaded one if its own description says so.
    """
    of_sessions = length_at(campaigns.c.session_ids) > 0
    # A service with a simulated cell called every uploaded campaign SIMULATED once: what counts is where the
    # readings come from, not where the campaign is kept (commit c7594c61).
    return case((of_sessions, _any_session_is()), else_=_its_description_says()).label("simulated")


def _any_session_is() -> ColumnElement[bool]:
    listed = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
    measured_in = sessions.alias("measured_in")
    return exists().where(measured_in.c.id == cast(listed.c.value, WHOLE), is_simulated(measured_in.c.setup))


def _its_description_says() -> ColumnElement[bool]:
    return func.coalesce(truth_at(campaigns.c.summary, "$.simulated"), false())


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
        # The first session calibrates; a second one only judges its model.
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


_DAY = 10  # letters of a date at the beginning of a time
# Without the two columns of megabytes: a list of campaigns would read all of them.
_LISTED = [column for column in campaigns.c if column.name not in {"archive", "campaign"}]


@dataclass(frozen=True, slots=True)
class NewCampaign:
    """A campaign to store."""

    name: str
    robot: str
    summary: CampaignSummary
    campaign: bytes  # as `documents.pack` packs it
    archive: bytes = b""  # as it was uploaded; empty: it was not
    session_ids: tuple[int, ...] = ()


class CampaignRepository(NumberedRecords[CampaignRecord]):
    """All queries about campaigns; a record is what is known of one without reading it."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "campaign", campaigns, _records, partial(from_row, CampaignRecord))

    async def add(self, campaign: NewCampaign, key: RequestKey | None = None) -> int:
        """Store a campaign and return its number."""
        return await self._database.write_new(lambda c: once(c, key, "campaign", lambda i: _add(i, campaign)))

    async def answered(self, key: RequestKey) -> int | None:
        """Return the campaign that a request with this key made before; raises KeyReusedError."""
        return await self._database.read(lambda c: answered_number(c, key, "campaign"))

    async def archive(self, campaign_id: int) -> bytes:
        """Return the zip that was uploaded, empty where none was; raises NotFoundError."""
        return bytes(await self._content(campaigns.c.archive, campaign_id))

    async def measured(self, campaign_id: int) -> tuple[str, str]:
        """Return serial number of the robot and day as sessions and upload say them; empty: they do not."""
        return await self._database.read(lambda c: _measured(c, campaign_id))

    async def content(self, campaign_id: int) -> bytes:
        """Return a campaign as `documents.pack` packs it; raises NotFoundError."""
        return bytes(await self._content(campaigns.c.campaign, campaign_id))


def _measured(connection: Connection, campaign_id: int) -> tuple[str, str]:
    origin = Origin(connection, campaign_id)
    return origin.robot_serial_number(), origin.measured_at()[:_DAY]


def _add(connection: Connection, campaign: NewCampaign) -> int:
    number = add_row(connection, campaigns, **to_row(campaign, campaigns))
    add_event(connection, "campaign.stored", {"campaign_id": number, "name": campaign.name})
    return number


def _records() -> Select[Any]:
    return select(*_LISTED, simulated_campaign())
