"""What every kind of report has in common; a report is made once for each content and shown again."""

import hashlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text
from truepose.storage.errors import NotFoundError
from truepose.storage.records import (
    CorrectionRecord,
    DiagnosisRecord,
    IdentificationRecord,
    SessionRecord,
    ValidationRecord,
)
from truepose.storage.results.reports import ReportRecord, ReportSubject
from truepose.web.context import Context
from truepose.web.drawn_reports import Drawn, draw_content, draw_page
from truepose.web.pages.rendering import Visit, moment, render_part
from truepose.web.pages.session_results import Choice

if TYPE_CHECKING:
    from markupsafe import Markup

    from truepose.reports.traceability import ReportConditions


LISTED: Final = 100  # of a kind, at most


Recorded: TypeAlias = (
    IdentificationRecord | ValidationRecord | DiagnosisRecord | CorrectionRecord | SessionRecord
)


@dataclass(frozen=True, slots=True)
class ReportRow:
    """A report as lists name it."""

    kind: str
    id: int
    title: str  # key of the catalogue
    recorded_at: str
    robot: str
    sentence: Text
    simulated: bool
    serial: str = ""


@dataclass(frozen=True, slots=True)
class Drawable:
    """What a report is made from, but for its number and the moment."""

    result: object  # what tells one from another, beside the conditions; records themselves never change
    conditions: Callable[[Catalogue], Awaitable["ReportConditions"]]
    of: Callable[["ReportConditions"], Drawn]  # the report, once the conditions are whole


Rows: TypeAlias = Callable[[Context, str], Awaitable[list[ReportRow]]]
Made: TypeAlias = Callable[[Context, int, Choice, Catalogue], Awaitable[Drawable]]


@dataclass(frozen=True, slots=True)
class ReportKind:
    """A kind of report."""

    name: str  # in its address
    title: str  # key of the catalogue
    rows: Rows  # the latest of a month (`2026-11`), or of all
    drawable: Made

    def row(
        self, record: Recorded, robot: str, sentence: Text, serial: str = "", title: str = ""
    ) -> ReportRow:
        """Return the report of a record as lists name it; `title` where it is not that of the kind."""
        return ReportRow(
            self.name,
            record.id,
            title or self.title,
            record.recorded_at,
            robot,
            sentence,
            record.simulated,
            serial,
        )


async def report_of(
    here: Context, kind: ReportKind, number: int, choice: Choice, words: Catalogue
) -> ReportRecord:
    """Return the report of a result as it is now, made anew where it would state something else."""
    subject, drawable = ReportSubject(kind.name, number), await kind.drawable(here, number, choice, words)
    # The language is no part of what is stated: a page in another one is the same revision (decision 0056).
    stated = _hash(drawable.result, await drawable.conditions(IN_ENGLISH))
    # Drawing takes seconds: two reports that stated something else and were drawn together were kept under
    # one number, one in the other's place. Whoever comes second draws again, with the next (commit 1f5fcfa3).
    while True:
        revision = await here.reports.revision_for(subject, stated)
        made = await _made(here, subject, revision, words)
        if made is not None:
            return made
        title = words.say("front.number", kind=words.say(kind.title), number=number, revision=revision)
        page = await _drawn(here, drawable, title, words)
        if await here.reports.keep(ReportRecord("", subject, revision, words.tag, stated, page)):
            return await here.reports.get(subject, revision, words.tag)


async def report_page(
    visit: Visit, kind: ReportKind, number: int, *, whole: bool, cover: bool = True
) -> "Markup | None":
    """Return what a report of a result says, for its page; it is no revision. None while it is drawn."""
    from truepose.reports.pages import content_of

    here, words = visit.here, visit.words
    drawable = await kind.drawable(here, number, Choice(), words)
    conditions = await drawable.conditions(words)

    async def draw() -> str:
        report = drawable.of(conditions)
        if not cover:
            return await here.drawing_desk.draw(draw_content, report)
        return content_of(await here.drawing_desk.draw(draw_page, report))

    stated = _hash(drawable.result, conditions)
    return await render_part(visit, f"{kind.name} {number} {stated}", draw, whole=whole)


async def _made(
    here: Context, subject: ReportSubject, revision: int, words: Catalogue
) -> ReportRecord | None:
    """Return a revision in this language; None where it was not made in it yet."""
    try:
        found = await here.reports.get(subject, revision, words.tag)
    except NotFoundError:
        return None
    return found if found.language == words.tag else None


def _hash(result: object, conditions: "ReportConditions") -> str:
    """Return a hash of all that a report states, but for the moment when it is made."""
    # The moment would make every report a new revision, and so would the head of the chain, which is not
    # there yet.
    stated = repr((result, replace(conditions, written_at="")))
    return hashlib.sha256(stated.encode()).hexdigest()


async def _drawn(here: Context, drawable: Drawable, number: str, words: Catalogue) -> str:
    conditions = replace(
        await drawable.conditions(words),
        number=number,
        written_at=moment(datetime.now(UTC).isoformat()),
        chain_head=(await here.database.head()).text,
    )
    return await here.drawing_desk.draw(draw_page, drawable.of(conditions))
