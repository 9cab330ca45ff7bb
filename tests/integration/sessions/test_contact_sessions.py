"""Sessions of closed loops on a real database: a request that is sent twice plans once."""

import asyncio
from types import SimpleNamespace

from tests.unit.service.sessions.contacts.fakes import CELL, SPHERE
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.sessions.contact.service import ContactSessions
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import RequestKey, SessionSetup

WISH = ContactPlanRequest("probe", (SPHERE,), 6, nest=2)


class Watched(ContactSessions):
    """Sessions with something to watch on their ways."""

    async def what_to_watch(self, setup, plan):
        return "Watch the column."


async def test_what_is_to_be_watched_is_said_once_where_one_request_comes_twice_at_once(database):
    sessions = SessionRepository(database)
    contacts = Watched(SimpleNamespace(serve=lambda kind: None, sessions=sessions))
    key = RequestKey("tap-1", "plan")

    first, second = await asyncio.gather(
        *(contacts.plan("left arm", SessionSetup(CELL), WISH, key) for _ in range(2))
    )

    assert first == second
    assert await sessions.notes(first) == ["Watch the column."]
