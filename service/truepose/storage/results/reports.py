"""Reports as they were made: of one result, a revision for each content, a page in each language."""

import zlib
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, desc, func, select

from truepose.storage.errors import NotFoundError
from truepose.storage.queries import Repository
from truepose.storage.record_insertion import add_row
from truepose.storage.rows import from_row
from truepose.storage.tables import reports


@dataclass(frozen=True, slots=True)
class ReportSubject:
    """What a report is of."""

    kind: str
    id: int  # of the result of that kind


@dataclass(frozen=True, slots=True)
class ReportRecord:
    """A report as it was made."""

    recorded_at: str
    subject: ReportSubject
    revision: int
    language: str
    stated_sha256: str
    page: str  # its content, without a frame


class ReportRepository(Repository):
    """All queries about reports."""

    async def revision_for(self, subject: ReportSubject, stated_sha256: str) -> int:
        """Return the revision that states this: the newest where it does, else the one to follow."""
        return await self._database.read(lambda connection: _revision(connection, subject, stated_sha256))

    async def newest(self, subject: ReportSubject) -> ReportRecord | None:
        """Return the newest revision, in whichever language it was made last."""
        row = await self._database.read(lambda connection: _newest(connection, subject))
        return None if row is None else _record(row)

    async def get(self, subject: ReportSubject, revision: int, language: str) -> ReportRecord:
        """Return a revision, in the language tag asked for if it was made in it; raises NotFoundError."""
        query = _of(subject).where(reports.c.revision == revision)
        # The language that is asked for, else the same without its region, else the one in which it was made
        # first.
        wanted = (desc(reports.c.language == one) for one in (language, language.partition("-")[0]))
        preferred = query.order_by(*wanted, reports.c.id).limit(1)
        row = await self._row(preferred)
        if row is None:
            raise NotFoundError("revision", revision)
        return _record(row)

    async def keep(self, made: ReportRecord) -> bool:
        """Store a report; one that was made meanwhile stays.

        Returns False, and keeps nothing, where its number is by now that of a report which states something
        else: the number stands on its page, so that it has to be drawn again.
        """
        return await self._database.write(lambda connection: _keep(connection, made))

    async def revisions(self, subject: ReportSubject) -> list[tuple[int, str]]:
        """Return each revision with when it was first made, oldest first."""
        first = func.min(reports.c.recorded_at)
        query = select(reports.c.revision, first).where(*_is(subject)).group_by(reports.c.revision)
        rows = await self._rows(query.order_by(reports.c.revision))
        return [(revision, recorded_at) for revision, recorded_at in rows]


def _newest(connection: Connection, subject: ReportSubject) -> Row[Any] | None:
    query = _of(subject).order_by(reports.c.revision.desc(), reports.c.id.desc()).limit(1)
    return connection.execute(query).one_or_none()


def _revision(connection: Connection, subject: ReportSubject, stated_sha256: str) -> int:
    newest = _newest(connection, subject)
    if newest is None:
        return 1
    # By what it states and not by its page: another language or another look is no new revision of what
    # somebody signed.
    same: bool = newest.stated_sha256 == stated_sha256
    return int(newest.revision) + (not same)


def _keep(connection: Connection, made: ReportRecord) -> bool:
    # Once more within the transaction: drawing takes seconds, and somebody else may have been quicker.
    if _revision(connection, made.subject, made.stated_sha256) != made.revision:
        return False
    same = _of(made.subject).where(reports.c.revision == made.revision, reports.c.language == made.language)
    if connection.execute(same).one_or_none() is not None:
        return True
    add_row(
        connection,
        reports,
        kind=made.subject.kind,
        subject_id=made.subject.id,
        revision=made.revision,
        language=made.language,
        stated_sha256=made.stated_sha256,
        # A page holds its figures as text, which shrinks to a fraction; it is kept for good.
        page=zlib.compress(made.page.encode()),
    )
    return True


def _is(subject: ReportSubject) -> tuple[Any, ...]:
    return (reports.c.kind == subject.kind, reports.c.subject_id == subject.id)


def _of(subject: ReportSubject) -> Any:
    return select(reports).where(*_is(subject))


def _record(row: Row[Any]) -> ReportRecord:
    subject, page = ReportSubject(row.kind, row.subject_id), zlib.decompress(row.page).decode()
    return from_row(ReportRecord, row, subject=subject, page=page)
