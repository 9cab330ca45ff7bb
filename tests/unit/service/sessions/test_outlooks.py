"""What the readings of a session promise is computed once, and anew once any of them is another one."""

from dataclasses import replace
from types import SimpleNamespace

from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.sessions.guide.guide import FEWEST, Outlooks


def read_at(*times_s):
    return tuple(SimpleNamespace(time_s=time_s) for time_s in times_s)


SESSION = MeasuredSession(1, None, read_at(*range(FEWEST)), read_at(0.5))


class Worker:
    """Says of each outlook which it was."""

    def __init__(self):
        self.asked = 0

    async def __call__(self, task, report):
        self.asked += 1
        return self.asked


async def test_an_outlook_is_computed_once():
    outlooks = Outlooks(Worker())

    assert [await outlooks.of(SESSION, 3) for _ in range(3)] == [1, 1, 1]


async def test_a_reading_that_was_taken_again_gives_another_outlook():
    outlooks = Outlooks(Worker())
    await outlooks.of(SESSION, 3)

    again = replace(SESSION, points=(*SESSION.points[1:], *read_at(99.0)))

    assert await outlooks.of(again, 3) == 2


async def test_a_world_frame_that_was_measured_anew_gives_another_outlook():
    outlooks = Outlooks(Worker())
    await outlooks.of(SESSION, 3)

    assert await outlooks.of(replace(SESSION, fixed_nests=read_at(98.0)), 3) == 2


async def test_only_the_sessions_that_were_asked_about_last_are_remembered():
    worker = Worker()
    outlooks = Outlooks(worker)
    for number in range(1, 21):
        await outlooks.of(replace(SESSION, id=number), 3)

    assert await outlooks.of(replace(SESSION, id=20), 3) == 20
    assert await outlooks.of(replace(SESSION, id=1), 3) == 21
    assert len(outlooks._known) < 20
