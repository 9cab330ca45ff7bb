"""A series brought as the table that its program might have written."""

import csv
import io
from collections.abc import AsyncIterator, Iterable
from typing import Final

from truepose.analysis.drafts import DraftDesk
from truepose.analysis.errors import NotReadyError
from truepose.domain.measurement.series import Values
from truepose.exchange.tables.texts import written_text
from truepose.storage.files.drafts import Draft
from truepose.storage.measurement.series import SeriesRecord, SeriesRepository
from truepose.storage.records import Page

_AT_ONCE: Final = 500


async def draft_of_series(series: SeriesRepository, drafts: DraftDesk, series_id: int) -> Draft:
    """Return a new draft with what a series holds; raises NotFoundError, ConflictError, NotReadyError."""
    record = await series.get(series_id)
    if not record.readings:
        raise NotReadyError(f"Series {series_id} holds no reading yet.")
    draft = await drafts.create()
    return await drafts.receive(draft.id, f"series {series_id}.csv", _table(series, record))


async def _table(series: SeriesRepository, record: SeriesRecord) -> AsyncIterator[bytes]:
    yield _lines([record.series.columns])
    for after in range(0, record.readings, _AT_ONCE):
        page = await series.readings(record.id, Page(after, min(_AT_ONCE, record.readings - after)))
        yield _lines(one.values for one in page)


def _lines(rows: Iterable[tuple[str, ...] | Values]) -> bytes:
    written = io.StringIO()
    csv.writer(written).writerows([_cell(value) for value in row] for row in rows)
    return written.getvalue().encode()


def _cell(value: str | float | None) -> str | float | None:
    return written_text(value) if isinstance(value, str) else value
