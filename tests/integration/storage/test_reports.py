"""Reports stay as they were made; another content is the next revision."""

from dataclasses import replace

import pytest

from truepose.storage.errors import NotFoundError
from truepose.storage.results.reports import ReportRecord, ReportRepository, ReportSubject

SUBJECT = ReportSubject("validation", 7)
FIRST = ReportRecord("", SUBJECT, 1, "en", "aa", "<h1>first</h1>")


@pytest.fixture
def reports(database):
    return ReportRepository(database)


async def test_the_same_content_is_the_same_revision_and_another_the_next(reports):
    assert await reports.revision_for(SUBJECT, "aa") == 1

    await reports.keep(FIRST)

    assert await reports.revision_for(SUBJECT, "aa") == 1
    assert await reports.revision_for(SUBJECT, "bb") == 2
    assert await reports.revision_for(ReportSubject("validation", 8), "aa") == 1
    assert await reports.revision_for(ReportSubject("diagnosis", 7), "bb") == 1


async def test_an_older_revision_stays_as_it_was(reports):
    await reports.keep(FIRST)
    await reports.keep(replace(FIRST, revision=2, stated_sha256="bb", page="<h1>second</h1>"))

    assert (await reports.get(SUBJECT, 1, "en")).page == "<h1>first</h1>"
    assert (await reports.newest(SUBJECT)).page == "<h1>second</h1>"
    assert [number for number, _ in await reports.revisions(SUBJECT)] == [1, 2]


async def test_what_was_made_meanwhile_stays(reports):
    await reports.keep(FIRST)
    await reports.keep(replace(FIRST, page="<h1>once more</h1>"))

    assert (await reports.get(SUBJECT, 1, "en")).page == "<h1>first</h1>"


async def test_two_reports_that_state_something_else_never_share_a_number(reports):
    await reports.keep(FIRST)
    numbers = [await reports.revision_for(SUBJECT, stated) for stated in ("bb", "cc")]
    drawn = [
        replace(FIRST, revision=number, stated_sha256=stated, language=language)
        for number, stated, language in zip(numbers, ("bb", "cc"), ("en", "de"), strict=True)
    ]

    kept = [await reports.keep(made) for made in drawn]

    assert kept == [True, False]
    assert (await reports.get(SUBJECT, 2, "de")).stated_sha256 == "bb"
    assert await reports.revision_for(SUBJECT, "cc") == 3


async def test_a_revision_is_shown_in_the_language_asked_for_or_in_the_one_there_is(reports):
    await reports.keep(FIRST)
    await reports.keep(replace(FIRST, language="fr", page="<h1>premier</h1>"))

    assert (await reports.get(SUBJECT, 1, "fr")).page == "<h1>premier</h1>"
    assert (await reports.get(SUBJECT, 1, "de")).page == "<h1>first</h1>"


async def test_a_revision_that_was_never_made_is_not_found(reports):
    assert await reports.newest(SUBJECT) is None
    with pytest.raises(NotFoundError):
        await reports.get(SUBJECT, 1, "en")
