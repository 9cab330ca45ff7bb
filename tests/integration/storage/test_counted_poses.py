"""The list of sessions counts the poses left out as the operator's page does, from the same ledger."""

import numpy as np
import pytest

from tests.helpers.domain.tracker_sessions import make_setup
from tests.unit.service.sessions.ballbar.sessions import Story, found, make_plan, make_pose
from truepose.domain.ledger import EntryKind
from truepose.sessions.ballbar import step_ids
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository

PLAN = make_plan((1, 2, 3, 12), precalibrate_after=2)


class Kept:
    """A story whose lines are kept in the storage as well."""

    def __init__(self, sessions, ledger, session_id):
        self.story = Story(PLAN)
        self._sessions, self._ledger, self._session_id = sessions, ledger, session_id
        self._kept = 0

    async def counts(self):
        """What the list of sessions says and what the page says."""
        for entry in self.story.entries[self._kept :]:
            await self._ledger.append(self._session_id, entry)
        self._kept = len(self.story.entries)
        listed = (await self._sessions.get(self._session_id)).skipped
        return listed, self.story.now.progress.skipped_poses


@pytest.fixture
async def kept(database):
    sessions = SessionRepository(database)
    return Kept(sessions, LedgerRepository(database), await sessions.add("first", make_setup(), PLAN))


async def test_a_pose_measured_at_a_later_attempt_is_left_out_by_nobody(kept):
    story = kept.story.until("placement-1/pose-1/leg-2-1")
    story.skip()
    assert await kept.counts() == (1, 1)

    story.until("placement-1/precalibrate-1")
    story.do(found(make_pose(1), make_pose(3), make_pose(12)))
    assert await kept.counts() == (0, 0)  # another attempt is open
    story.until("placement-1/pose-1/again/detach")

    assert await kept.counts() == (0, 0)


async def test_a_skip_that_was_taken_back_leaves_nothing_out(kept):
    story = kept.story.until("placement-1/pose-1/move")
    story.skip()
    assert await kept.counts() == (1, 1)

    story.back()

    assert await kept.counts() == (0, 0)


async def test_a_pose_skipped_at_every_attempt_stays_left_out(kept):
    story = kept.story
    for step in ("pose-1/move", "pose-1/again/move", "pose-1/again-2/move"):
        story.until(f"placement-1/{step}").skip()
        assert await kept.counts() == (1, 1)
        while story.present is not None and "precalibrate" not in story.present:
            story.do()
        if story.present is not None:
            story.do(found(*map(make_pose, (1, 2, 3, 12))))

    while story.present is not None:
        story.do()

    assert await kept.counts() == (1, 1)


@pytest.mark.parametrize("seed", range(2))
async def test_list_and_page_agree_whatever_was_skipped_taken_back_and_tried_again(kept, seed):
    chance, story = np.random.default_rng(seed), kept.story
    for _ in range(90):
        if story.present is None:
            break
        await _whatever(story, chance)
        listed, shown = await kept.counts()
        assert listed == shown, story.entries[-1]


async def _whatever(story, chance):
    drawn = chance.random()
    if "precalibrate" in story.present and drawn < 0.2:
        story.add(story.show(), EntryKind.SKIPPED, text="later")
    elif "precalibrate" in story.present:
        story.do(found(*map(make_pose, (1, 2, 3, 12))))
    elif drawn < 0.1 and story.now.back_to is not None:
        story.back()
    elif drawn < 0.3 and step_ids.is_of_a_pose(story.present) and "detach" not in story.present:
        story.skip()
    else:
        story.do()
