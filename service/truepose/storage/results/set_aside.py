"""What a person had set aside when readings were last analysed."""

from typing import Any, Final

from sqlalchemy import ColumnElement, Select, Table, cast, select, true

from truepose.domain.campaign import ReadingsSetAside
from truepose.storage.documents import from_document, from_json
from truepose.storage.engine.dialects import WHOLE, entries_at, text_at
from truepose.storage.queries import Repository
from truepose.storage.tables import campaigns, diagnoses, identifications

_LISTED: Final = entries_at(campaigns.c.session_ids).table_valued("value", name="listed")
# Where each kind of result says it. Of a diagnosis the summary: the whole document has megabytes of curves.
_RESULTS: Final = ((identifications, identifications.c.document), (diagnoses, diagnoses.c.summary))


class SetAsideRepository(Repository):
    """Finds the readings that the newest identification or diagnosis was made without."""

    async def of_session(self, session_id: int) -> ReadingsSetAside | None:
        """Return what the newest result of a session's readings leaves out; None: nothing, or no result."""
        found: list[Any] = []
        for table, said in _RESULTS:
            query = _results(table, said).join(_LISTED, true())
            rows = await self._rows(query.where(cast(_LISTED.c.value, WHOLE) == session_id))
            # The first session calibrates; of one that only judges, nothing is set aside.
            found += [row for row in rows if row.session_ids[0] == session_id]
        return _newest(found)

    async def of_campaign(self, campaign_id: int) -> ReadingsSetAside | None:
        """Return the same of a campaign; of one that a session measured, of that session."""
        sessions = await self._value(select(campaigns.c.session_ids).where(campaigns.c.id == campaign_id))
        if sessions:
            return await self.of_session(sessions[0])
        return _newest([
            row
            for table, said in _RESULTS
            for row in await self._rows(_results(table, said).where(campaigns.c.id == campaign_id))
        ])


def _results(table: Table, said: ColumnElement[Any]) -> Select[Any]:
    return select(
        table.c.job_id, campaigns.c.session_ids, text_at(said, "$.set_aside").label("aside")
    ).join_from(table, campaigns, campaigns.c.id == table.c.campaign_id)


def _newest(rows: list[Any]) -> ReadingsSetAside | None:
    """Return what the result says that was asked for last."""
    # By their jobs, which both kinds of results have; their own numbers count each kind alone.
    newest = max(rows, key=lambda row: row.job_id, default=None)
    if newest is None or newest.aside is None:
        return None
    return from_document(ReadingsSetAside, from_json(newest.aside))
