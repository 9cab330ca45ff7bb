"""A report is made once for each content: asked for again, the page that was made is shown."""

import asyncio
import hashlib
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from truepose.storage.calibration.reports import ReportRecord, ReportSubject
from truepose.storage.errors import NotFoundError
from truepose.web.context import Context
from truepose.web.reports.kinds import Drawable, ReportKind
from truepose.web.results.kinds import Choice
from truepose.web.visiting.drawn import drawn_part
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visit
from truepose.words.catalogue import IN_ENGLISH, Catalogue

if TYPE_CHECKING:
    from markupsafe import Markup

    from truepose.reports.traceability.conditions import ReportConditions


async def report_of(
    here: Context, kind: ReportKind, number: int, choice: Choice, words: Catalogue
) -> ReportRecord:
    """Return the report of a result as it is now, made anew where it would state something else."""
    subject, drawable = ReportSubject(kind.name, number), await kind.drawable(here, number, choice, words)
    stated = await _stated(drawable)
    revision = await here.reports.revision_for(subject, stated)
    made = await _made(here, subject, revision, words)
    if made is not None:
        return made
    page = await _drawn(here, drawable, _numbered(kind, number, revision, words), words)
    await here.reports.keep(ReportRecord("", subject, revision, words.tag, stated, page))
    return await here.reports.get(subject, revision, words.tag)


async def drawn_as_report(visit: Visit, kind: ReportKind, number: int, *, whole: bool) -> "Markup | None":
    """Return what a report of a result says, for its page; it is no revision. None while it is drawn."""
    from truepose.reports.pages import content_of

    here, words = visit.here, visit.words
    drawable = await kind.drawable(here, number, Choice(), words)
    conditions = await drawable.conditions(words)

    async def draw() -> str:
        return content_of(await here.drawing_desk.draw(drawable.draw, drawable.of(conditions)))

    stated = await asyncio.to_thread(_hash, drawable.document, conditions)
    return await drawn_part(visit, f"{kind.name} {number} {stated}", draw, whole=whole)


async def _made(
    here: Context, subject: ReportSubject, revision: int, words: Catalogue
) -> ReportRecord | None:
    """Return a revision in this language; None where it was not made in it yet."""
    try:
        found = await here.reports.get(subject, revision, words.tag)
    except NotFoundError:
        return None
    return found if found.language == words.tag else None


async def _stated(drawable: Drawable) -> str:
    """Return a hash of all that a report states, but for the moment when it is made."""
    return await asyncio.to_thread(_hash, drawable.document, await drawable.conditions(IN_ENGLISH))


def _hash(document: object, conditions: "ReportConditions") -> str:
    stated = repr((document, replace(conditions, written_at="")))
    return hashlib.sha256(stated.encode()).hexdigest()


def _numbered(kind: ReportKind, number: int, revision: int, words: Catalogue) -> str:
    return words.say("front.number", kind=words.say(kind.title), number=number, revision=revision)


async def _drawn(here: Context, drawable: Drawable, number: str, words: Catalogue) -> str:
    conditions = replace(
        await drawable.conditions(words),
        number=number,
        written_at=moment(datetime.now(UTC).isoformat()),
        chain_head=(await here.database.head()).text,
    )
    return await here.drawing_desk.draw(drawable.draw, drawable.of(conditions))
