"""Campaigns: as arrays, and the zip that was uploaded."""

from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, Select, func, select

from truepose.storage.calibration.origins import Origin, simulated_campaign
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import NotFoundError
from truepose.storage.events import add_event
from truepose.storage.numbered import NumberedRecords
from truepose.storage.records import CampaignRecord, CampaignSummary, RequestKey
from truepose.storage.request_keys import answered, once
from truepose.storage.rows import add_row
from truepose.storage.tables import campaigns

_DAY = 10  # letters of a date at the beginning of a time
_LISTED = [column for column in campaigns.c if column.name not in {"archive", "campaign"}]


@dataclass(frozen=True, slots=True)
class NewCampaign:
    """A campaign to store."""

    name: str
    robot: str
    summary: CampaignSummary
    campaign: bytes  # as `storage.columns` packs it
    archive: bytes = b""  # as it was uploaded; empty: it was not
    session_ids: tuple[int, ...] = ()


class CampaignRepository(NumberedRecords[CampaignRecord]):
    """All queries about campaigns; a record is what is known of one without reading it."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "campaign", campaigns, _records, _record)

    async def add(self, campaign: NewCampaign, key: RequestKey | None = None) -> int:
        """Store a campaign and return its number."""
        return await self._database.write_new(lambda c: once(c, key, "campaign", lambda i: _add(i, campaign)))

    async def answered(self, key: RequestKey) -> int | None:
        """Return the campaign that a request with this key made before; raises KeyReusedError."""
        return await self._database.read(lambda c: answered(c, key, "campaign"))

    async def archive(self, campaign_id: int) -> bytes:
        """Return the zip that was uploaded, empty where none was; raises NotFoundError."""
        return await self._content(campaigns.c.archive, campaign_id)

    async def measured(self, campaign_id: int) -> tuple[str, str]:
        """Return serial number of the robot and day as sessions and upload say them; empty: they do not."""
        return await self._database.read(lambda c: _measured(c, campaign_id))

    async def content(self, campaign_id: int) -> bytes:
        """Return a campaign as `storage.columns` packs it, an older one as its zip; raises NotFoundError."""
        return await self._content(func.coalesce(campaigns.c.campaign, campaigns.c.archive), campaign_id)

    async def _content(self, column: ColumnElement[bytes], campaign_id: int) -> bytes:
        query = select(column).where(campaigns.c.id == campaign_id)
        found = await self._database.read(lambda c: c.scalar(query))
        if found is None:
            raise NotFoundError("campaign", campaign_id)
        return bytes(found)


def _measured(connection: Connection, campaign_id: int) -> tuple[str, str]:
    origin = Origin(connection, campaign_id)
    return origin.robot_serial_number(), origin.measured_at()[:_DAY]


def _add(connection: Connection, campaign: NewCampaign) -> int:
    number = add_row(
        connection,
        campaigns,
        name=campaign.name,
        robot=campaign.robot,
        summary=to_document(campaign.summary),
        session_ids=list(campaign.session_ids),
        archive=campaign.archive,
        campaign=campaign.campaign,
    )
    add_event(connection, "campaign.stored", {"campaign_id": number, "name": campaign.name})
    return number


def _records() -> Select[Any]:
    return select(*_LISTED, simulated_campaign())


def _record(row: Row[Any]) -> CampaignRecord:
    summary = from_document(CampaignSummary, row.summary)
    return CampaignRecord(
        row.id, row.recorded_at, row.name, row.robot, tuple(row.session_ids), bool(row.simulated), summary
    )
