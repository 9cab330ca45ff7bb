"""Drafts on the disk: kept whole, ended by themselves, never more than there is room for."""

import json
import os
import sys
from datetime import UTC, datetime, timedelta

import pytest

from truepose.storage import drafts as drafts_module
from truepose.storage.drafts import KEPT, MOST_DRAFTS, DraftFolder
from truepose.storage.errors import ConflictError, NotFoundError, StorageUnavailableError

HOUR_S = 3600.0


@pytest.fixture
def running_s():
    """For how long the service has run."""
    return [0.0]


@pytest.fixture
def drafts(tmp_path, running_s):
    return DraftFolder(tmp_path / "drafts", lambda: running_s[0])


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


def left_alone(state, whole=True):
    """Let nobody have touched a draft for two weeks and an hour; only its file says that of a torn one."""
    old = datetime.now(UTC) - KEPT - timedelta(hours=1)
    document = json.loads(state.read_text()) | {"changed_at": old.isoformat(timespec="seconds")}
    state.write_text(json.dumps(document) if whole else "{")
    os.utime(state, (old.timestamp(), old.timestamp()))


@pytest.mark.parametrize("whole", [True, False])
def test_what_nobody_touched_for_two_weeks_ends_a_day_later(drafts, tmp_path, running_s, whole):
    number = drafts.create().id
    left_alone(tmp_path / "drafts" / str(number) / "draft.json", whole)

    kept = []
    for running_s[0] in (0.0, 23 * HOUR_S, 24 * HOUR_S):
        drafts.all()
        kept.append(drafts.numbers())

    assert kept == [[number], [number], []]


def test_a_clock_that_was_set_forward_and_right_again_ends_nothing(drafts, tmp_path, running_s):
    number = drafts.create().id
    state = tmp_path / "drafts" / str(number) / "draft.json"
    right = state.read_text()

    for running_s[0], wrong in ((0.0, True), (HOUR_S, False), (40 * HOUR_S, True)):
        left_alone(state) if wrong else state.write_text(right)
        drafts.all()

    assert drafts.numbers() == [number]


def test_one_whose_creation_was_cut_short_ends(drafts, tmp_path, running_s):
    (tmp_path / "drafts" / "7").mkdir(parents=True)

    for running_s[0] in (0.0, 24 * HOUR_S):
        drafts.all()

    assert drafts.numbers() == []


def test_a_draft_that_was_touched_stays(drafts):
    number = drafts.create().id

    assert [draft.id for draft in drafts.all()] == [number]


def test_one_that_cannot_be_read_keeps_nobody_from_the_others(drafts, tmp_path, caplog):
    spoiled, other = drafts.create().id, drafts.create().id
    (tmp_path / "drafts" / str(spoiled) / "draft.json").write_bytes(b"{")

    assert [draft.id for draft in drafts.all()] == [other]
    assert drafts.create().id == 3
    assert f"Draft {spoiled} cannot be read" in caplog.text
    with pytest.raises(StorageUnavailableError):
        drafts.get(spoiled)

    drafts.remove(spoiled)
    assert drafts.numbers() == [other, 3]


@pytest.mark.parametrize("left", ["", "\0\0\0"])
def test_a_last_number_that_a_loss_of_power_took_is_begun_anew(drafts, tmp_path, left):
    drafts.create()
    (tmp_path / "drafts" / "last").write_text(left)

    assert [drafts.create().id, drafts.create().id] == [2, 3]


@pytest.mark.skipif(sys.platform != "linux", reason="what is synced is looked for in /proc")
def test_the_last_number_is_on_the_disk_before_anybody_has_it(drafts, tmp_path, monkeypatch):
    drafts.create()
    synced = []
    monkeypatch.setattr(os, "fsync", lambda file: synced.append(os.readlink(f"/proc/self/fd/{file}")))

    drafts.create()

    assert str(tmp_path / "drafts" / "last.part") in synced
    assert (tmp_path / "drafts" / "last").read_text() == "2"


def test_two_that_are_brought_together_are_not_larger_than_one_draft_may_be(drafts, monkeypatch):
    monkeypatch.setattr(drafts_module, "MOST_BYTES", 10)
    number = drafts.create().id

    with drafts.receiving(number) as first, drafts.receiving(number) as second:
        first.write(b"seven by")
        second.write(b"seven by")
        first.keep("a.csv")
        with pytest.raises(ConflictError, match="at most"):
            second.keep("b.csv")

    assert [file.name for file in drafts.get(number).files] == ["a.csv"]


def test_there_are_not_more_than_so_many(drafts):
    for _ in range(MOST_DRAFTS):
        drafts.create()

    with pytest.raises(ConflictError, match="delete one"):
        drafts.create()


def test_what_is_said_anew_is_not_what_a_campaign_was_made_of(drafts):
    draft = drafts.create()
    drafts.keep_made(draft, 7, (1, 2))

    assert drafts.get(draft.id).campaign_id == 7
    assert drafts.keep_choices(draft.id, {"u_mm": 0.02}).campaign_id is None


def test_of_one_that_was_changed_while_a_campaign_was_made_nothing_is_made_yet(drafts):
    draft = drafts.create()
    changed = drafts.keep_choices(draft.id, {"u_mm": 0.02})

    made = drafts.keep_made(draft, 7, (1, 2))

    assert (made.campaign_id, made.job_ids) == (7, (1, 2))
    assert drafts.get(draft.id) == changed


@pytest.mark.parametrize("number", [0, 99])
def test_a_number_of_nothing_is_said_so(drafts, number):
    with pytest.raises(NotFoundError):
        drafts.get(number)
