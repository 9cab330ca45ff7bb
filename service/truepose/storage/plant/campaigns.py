"""Campaigns that a plant has collected: which robot, by what, on which day, and their readings."""

from typing import Final

from sqlalchemy import select

from truepose.storage.database import Database
from truepose.storage.documents import from_json
from truepose.storage.errors import DamagedDatabaseError
from truepose.storage.leaving.typed_rows import untyped
from truepose.storage.plant.looking import ResultSeen, result_seen, results_seen
from truepose.storage.tables.of_plants import plant_journal, plant_results

_RECORD: Final = "campaigns"


class CollectedCampaigns:
    """All queries about campaigns in the journals of cells."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def all(self, robot: str | None = None) -> list[ResultSeen]:
        """Return the campaigns of all robots, or of a type, in the order in which they were collected."""
        query = results_seen().where(plant_results.c.kind == "campaign").order_by(plant_results.c.id)
        if robot is not None:
            query = query.where(plant_results.c.robot == robot)
        return await self._database.read(lambda c: [result_seen(row) for row in c.execute(query)])

    async def content(self, campaign: ResultSeen) -> bytes:
        """Return a campaign as its cell has stored it; raises DamagedDatabaseError where it is not there."""
        here = plant_journal.c.branch_id == campaign.branch_id
        of_it = (plant_journal.c.record == _RECORD) & (plant_journal.c.record_id == campaign.record_id)
        query = select(plant_journal.c.content).where(here, of_it)
        text = await self._database.read(lambda connection: connection.scalar(query))
        row = {} if text is None else untyped(from_json(text))
        found = row.get("campaign") or row.get("archive")
        if not isinstance(found, bytes):
            raise DamagedDatabaseError(
                f"Campaign {campaign.record_id} of {campaign.cell} came without its readings; "
                "'truepose verify' says what else is damaged."
            )
        return found
