"""Drafts on the disk: kept whole, ended by themselves, never more than there is room for."""

import json
from datetime import UTC, datetime, timedelta

import pytest

from truepose.storage.drafts import KEPT, MOST_DRAFTS, DraftFolder
from truepose.storage.errors import ConflictError, NotFoundError


@pytest.fixture
def drafts(tmp_path):
    return DraftFolder(tmp_path / "drafts")


def take(drafts, number, name, data):
    with drafts.receiving(number) as incoming:
        incoming.write(data)
        return incoming.keep(name)


def test_a_file_counts_once_it_is_whole(drafts, tmp_path):
    number = drafts.create().id
    with drafts.receiving(number) as incoming:
        incoming.write(b"half")

    assert drafts.get(number).files == ()
    assert not list(tmp_path.rglob("*.part"))
    assert (
        drafts.path(number, take(drafts, number, "a.csv", b"whole").files[0].number).read_bytes() == b"whole"
    )


def test_what_nobody_touched_for_two_weeks_ends(drafts, tmp_path):
    number = drafts.create().id
    state = tmp_path / "drafts" / str(number) / "draft.json"
    old = (datetime.now(UTC) - KEPT - timedelta(hours=1)).isoformat(timespec="seconds")
    state.write_text(json.dumps(json.loads(state.read_text()) | {"changed_at": old}))

    assert drafts.all() == ()
    with pytest.raises(NotFoundError):
        drafts.get(number)


def test_a_draft_that_was_touched_stays(drafts):
    number = drafts.create().id

    assert [draft.id for draft in drafts.all()] == [number]


def test_there_are_not_more_than_so_many(drafts):
    for _ in range(MOST_DRAFTS):
        drafts.create()

    with pytest.raises(ConflictError, match="throw one away"):
        drafts.create()


def test_what_is_said_anew_is_not_what_a_campaign_was_made_of(drafts):
    number = drafts.create().id
    drafts.keep_made(number, 7, (1, 2))

    assert drafts.get(number).campaign_id == 7
    assert drafts.keep_choices(number, {"u_mm": 0.02}).campaign_id is None


@pytest.mark.parametrize("number", [0, 99])
def test_a_number_of_nothing_is_said_so(drafts, number):
    with pytest.raises(NotFoundError):
        drafts.get(number)
