"""A report is made once for each content: asked for again, the page that was made is shown."""

import hashlib
from dataclasses import replace
from datetime import UTC, datetime

from truepose.storage.calibration.reports import ReportRecord, ReportSubject
from truepose.storage.errors import NotFoundError
from truepose.web.context import Context
from truepose.web.reports.kinds import Drawable, ReportKind
from truepose.web.results.kinds import Choice
from truepose.web.visiting.moments import moment
from truepose.words.catalogue import IN_ENGLISH, Catalogue


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


async def drawn(here: Context, kind: ReportKind, number: int, words: Catalogue) -> str:
    """Return the report of a result as a page that is kept nowhere."""
    drawable = await kind.drawable(here, number, Choice(), words)
    return await here.drawing_desk.draw(drawable.draw, drawable.of(await drawable.conditions(words)))


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
    conditions = replace(await drawable.conditions(IN_ENGLISH), written_at="")
    return hashlib.sha256(repr((drawable.document, conditions)).encode()).hexdigest()


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
