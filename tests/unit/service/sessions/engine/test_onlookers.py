"""What only looks on while a session is under way."""

from truepose.sessions.engine.runner import with_onlookers


async def test_a_session_that_ends_at_once_leaves_nobody_who_was_never_asked():
    asked = []

    async def look():
        asked.append(1)

    async with with_onlookers([look]):
        pass  # over before the onlooker had its turn

    assert asked == []
