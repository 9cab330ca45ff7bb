"""What only looks on while a session is under way."""

from truepose.sessions.engine.runner import looked_on


async def test_a_session_that_ends_at_once_leaves_nobody_who_was_never_asked():
    asked = []

    async def look():
        asked.append(1)

    async with looked_on([look]):
        pass  # over before the onlooker had its turn

    assert asked == []
