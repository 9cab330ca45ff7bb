"""Whatever persons do and whatever fails, the arm goes straight ways that were looked at, and no others.

A robot notes each motion, eyes note which ways were looked at and whether a person was told of them. The
book of both is the test's own.
"""

import asyncio
import contextlib
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.ballbar import fakes as ballbar
from tests.unit.service.sessions.ballbar.sessions import CUP, KIT, found, make_plan
from tests.unit.service.sessions.contacts import fakes as contacts
from tests.unit.service.sessions.tracker import fakes as tracker
from tests.unit.service.sessions.tracker.test_camera_sessions import camera_cell
from truepose.domain.session import PlannedStop, SessionState, Work
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.sessions.ballbar.plan import steps
from truepose.sessions.contact.runner import ContactRunner
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.engine.states import has_ended
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.errors import ConnectionLostError, TargetRefusedError

GAUGES = contacts.planned(3)
TOUCHES = message("room.be_ready")
AT_ONCE_RAD = 1e-3  # rounding of what a controller states, and the tolerance of a plan


def lies_on(point, way):
    start, end = map(np.array, way)
    length2 = max(float(np.sum((end - start) ** 2)), 1e-30)
    share = np.clip(np.dot(np.array(point) - start, end - start) / length2, 0.0, 1.0)
    return np.max(np.abs(np.array(point) - start - share * (end - start))) <= AT_ONCE_RAD


class Book:
    """Which ways were looked at, or told to a person who let the session go on; and which were gone."""

    def __init__(self, *, narrow):
        self.narrow = narrow  # something touches on all ways but the plan's
        self.strange = 0  # looks at ways that nobody had looked at
        self.allowed = []
        self.told = []
        self.gone = []

    async def look(self, ways):
        seen = [*zip(ways.start_rad.tolist(), ways.end_rad.tolist(), strict=True)]
        strange = not all(map(self.is_known, seen))
        self.strange += strange
        if self.narrow and strange and (len(seen) == 1 or self.allowed):
            self.told = seen
            return TOUCHES
        self.allowed += seen
        return ""

    def answered(self, asked):
        """Take that a person let the session go on after this question."""
        if english(TOUCHES) in asked:
            self.allowed += self.told
        self.told = []

    def go(self, start, end):
        self.gone.append((start, end))

    def unseen(self):
        """Return the motions that nobody had looked at."""
        moved = [way for way in self.gone if max(map(abs, np.subtract(*way))) > AT_ONCE_RAD]
        return [way for way in moved if not self.is_known(way)]

    def is_known(self, way):
        """Whether a way lies on one that was looked at, or told."""
        start, end = way
        return any(lies_on(start, known) and lies_on(end, known) for known in self.allowed)


class Watched:
    """A robot that notes each motion; what is to happen in the midst of one is asked of `at_motion`."""

    def __init__(self, robot, book):
        self._robot = robot
        self._book = book
        self._move = robot.move_joints
        self.at_motion = {}  # number of the motion, from 0
        robot.move_joints = self.move

    async def move(self, target):
        start, number = tuple(self._robot.joints), len(self._book.gone)
        self._book.go(start, target)
        act = self.at_motion.get(number)
        if act is None:
            await self._move(target)
            return
        halfway = tuple(float(a + b) / 2 for a, b in zip(start, target, strict=True))
        await act(self, halfway)

    # what may happen in the midst of a motion

    async def lose_link(self, halfway):
        self._robot.joints, self._robot.connected = halfway, False
        raise ConnectionLostError("the link is down")

    async def refuse(self, halfway):
        raise TargetRefusedError("out of reach")

    def pressing(self, *acts):
        """Return what presses buttons while the arm goes; the motion ends all the same."""

        async def press(_, halfway):
            for act in acts:
                await self.session.runner.act(replace(act, key=f"{act.name}-{act.step_id}"))
            await self._move(self._book.gone[-1][1])

        return press

    async def add(self, halfway):
        await self.session.add(tracker.make_stop(9))
        await self._move(self._book.gone[-1][1])

    async def die(self, halfway):
        """Have the program die and the arm come to rest somewhere on its way."""
        self._robot.joints = halfway
        self.session.restart = True
        await asyncio.sleep(HANGS_S)


def act(name, step_id=None):
    reason = "in the way" if name is CommandName.SKIP else ""
    return OperatorCommand(name, "Eva", step_id=step_id, reason=reason)


SKIP, RETRY, PAUSE, STOP = CommandName.SKIP, CommandName.RETRY, CommandName.PAUSE, CommandName.STOP


class Unattended:
    """A session of points, poses or gauges; a person confirms and resumes whatever is asked."""

    def __init__(self, kind, book):
        self.kind, self.book = kind, book
        self.bench = {"camera": camera_cell, "contact": contacts.Bench}.get(kind, tracker.FakeCell)()
        self.robot = Watched(self.bench.robot, book)
        self.robot.session = self
        self.restart = False
        self.when_asked = {}  # number of the question, from 0
        self.asked = 0
        self.nest = 4 if kind == "camera" else 1
        self.stops = tuple(replace(tracker.make_stop(config), nest=self.nest) for config in range(1, 6))
        if kind == "drift":
            self.stops = working_stops(*(stop.joints_rad for stop in self.stops))

    async def add(self, stop):
        """Add a stop; it comes last, after a question."""

        async def keep():
            self.stops += added

        added = (replace(stop, nest=self.nest),)
        await self.runner.add_stops(added, keep)

    def _runner(self):
        entries = tuple(self.bench.journal.entries)
        if self.kind == "contact":
            cell = self.bench.cell(look_at_ways=self.book.look)
            return ContactRunner(GAUGES, cell, self.bench.journal, entries)
        changes = {"measures": "poses"} if self.kind == "camera" else {}
        changes |= {"approach_offset_rad": None, "reference_every": 99} if self.kind == "drift" else {}
        plan = tracker.make_plan(stops=self.stops, registration_readings=2, **changes)
        cell = replace(self.bench.cell, look_at_ways=self.book.look)
        return TrackerRunner(plan, cell, self.bench.journal, entries)

    async def to_the_end(self):
        async with asyncio.timeout(HANGS_S):
            while True:
                self.runner, self.restart = self._runner(), False
                self.running = asyncio.create_task(self.runner.run())
                with contextlib.suppress(asyncio.CancelledError):
                    return await self._attend()
                assert self.restart
                await self.bench.robot.close()

    async def _attend(self):
        while not self.running.done():
            await asyncio.sleep(0)
            if self.restart:
                self.running.cancel()
                await self.running
            prompt = self.runner.prompt
            if prompt is not None:
                await self._answer(prompt)
        return self.running.result()

    async def _answer(self, prompt):
        number, self.asked = self.asked, self.asked + 1
        if number in self.when_asked:
            await self.when_asked[number](self)
        if self.asked > 40:
            await self.runner.act(act(CommandName.ABORT))
            return
        self.book.answered(english(prompt.message))
        await self.runner.act(act(prompt.answered_by))


def working_stops(first, *others):
    """Return one place, read before and after the arm went round all of them for a minute."""
    work = Work(60.0, (*reversed(others), first))
    again = PlannedStop(2, first, 1, repeat_of=1, begin_rad=others[0], group=2, work=work)
    return PlannedStop(1, first, 1, begin_rad=others[0], group=1), again


async def by_hand(session):
    """Move the arm to where no plan has it."""
    session.bench.robot.joints = (0.3, 0.4, -0.2, 0.5, 0.6, -0.7)


TRACKER_ACTS = {
    "nothing": {},
    "one ahead is left out": {3: ("press", act(SKIP, "stop-4"))},
    "two ahead are left out": {3: ("press", act(SKIP, "stop-3"), act(SKIP, "stop-4"))},
    "the present one is left out": {4: ("press", act(SKIP, "stop-3"))},
    "the first is left out": {0: ("press", act(SKIP, "stop-1"))},
    "one that was measured is left out, then wanted again": {
        5: ("press", act(SKIP, "stop-1"), act(RETRY, "stop-1"))
    },
    "one is wanted again": {6: ("press", act(RETRY, "stop-2"))},
    "one is left out, then wanted again": {
        3: ("press", act(SKIP, "stop-4")),
        5: ("press", act(RETRY, "stop-4")),
    },
    "one is added": {2: ("add",)},
    "one is added, the last is left out": {3: ("add",), 5: ("press", act(SKIP, "stop-5"))},
    "a pause": {3: ("press", act(PAUSE))},
    "a pause and one left out": {4: ("press", act(PAUSE), act(SKIP, "stop-3"))},
    "a stop": {4: ("press", act(STOP))},
    "a stop and one left out": {4: ("press", act(STOP), act(SKIP, "stop-4"))},
    "the link is lost": {4: ("lose_link",)},
    "the link is lost twice at one": {4: ("lose_link",), 5: ("lose_link",)},
    "a target is refused": {4: ("refuse",)},
    "two targets are refused": {4: ("refuse",), 5: ("refuse",)},
    "the program is killed": {5: ("die",)},
    "the program is killed, then one is left out": {4: ("die",), 5: ("press", act(SKIP, "stop-3"))},
}  # fmt: skip


def plan_acts(robot, acts):
    """Have acts happen in the midst of motions, by the number of the motion."""
    for number, (what, *pressed) in acts.items():
        if what == "press":
            robot.at_motion[number] = robot.pressing(*pressed)
        else:
            robot.at_motion[number] = getattr(type(robot), what)


NARROW = pytest.mark.parametrize("narrow", [False, True], ids=["roomy", "narrow"])


DRIFT_ACTS = {
    "nothing": {},
    "a pause at work": {9: ("press", act(PAUSE))},
    "the link is lost at work": {9: ("lose_link",)},
    "a target is refused at work": {9: ("refuse",)},
    "the program is killed at work": {9: ("die",)},
    "the program is killed at work, twice": {5: ("die",), 12: ("die",)},
    "work is left out": {9: ("press", act(SKIP, "stop-2"))},
}


CONTACT_ACTS = {
    "nothing": {},
    **{f"a pause at motion {n}": {n: ("press", act(PAUSE))} for n in (0, 2, 5, 9)},
    **{f"a stop at motion {n}": {n: ("press", act(STOP))} for n in (1, 4)},
    **{f"the link is lost at motion {n}": {n: ("lose_link",)} for n in (0, 1, 3, 6)},
    **{f"a target is refused at motion {n}": {n: ("refuse",)} for n in (0, 1, 3)},
    **{f"the program is killed at motion {n}": {n: ("die",)} for n in (0, 1, 4, 8)},
}


ACTS_OF = {"tracker": TRACKER_ACTS, "camera": TRACKER_ACTS, "drift": DRIFT_ACTS, "contact": CONTACT_ACTS}
UNATTENDED = {
    f"{kind}, {what}": (kind, acts) for kind, of_kind in ACTS_OF.items() for what, acts in of_kind.items()
}


@NARROW
@pytest.mark.parametrize(("kind", "acts"), UNATTENDED.values(), ids=UNATTENDED)
async def test_an_arm_that_nobody_stands_beside_goes_no_way_that_nobody_looked_at(kind, acts, narrow):
    book = Book(narrow=narrow)
    session = Unattended(kind, book)
    plan_acts(session.robot, acts)

    assert await session.to_the_end() is SessionState.FINISHED

    assert book.unseen() == []
    assert len(book.gone) > (9 if kind == "drift" else 5)


@NARROW
@pytest.mark.parametrize("kind", ["tracker", "camera", "contact"])
async def test_an_arm_that_was_moved_by_hand_goes_no_way_that_nobody_looked_at(kind, narrow):
    book = Book(narrow=narrow)
    session = Unattended(kind, book)
    plan_acts(session.robot, {3: ("press", act(PAUSE))})
    last = 3 if kind == "contact" else 1
    session.when_asked = {last: by_hand, last + 1: by_hand}

    await session.to_the_end()

    assert book.unseen() == []
    assert len(book.gone) > 3


def spread(place):
    """Return a placement whose places are all over the ranges of the joints, and not on one line."""

    def elsewhere(joints_rad):
        rng = np.random.default_rng(round(1000.0 * abs(joints_rad[0])))
        return tuple(rng.uniform(-0.9, 0.9, 6).tolist())

    def moved(stop):
        return replace(
            stop, joints_rad=elsewhere(stop.joints_rad), via_rad=tuple(map(elsewhere, stop.via_rad))
        )

    setups, poses = tuple(map(moved, place.setups)), tuple(map(moved, place.poses))
    return replace(place, setups=setups, poses=poses, away=moved(place.away))


def spread_plan(*configs, **changes):
    plan = make_plan(*configs, stable_s=0.1, settle_s=0.0, **changes)
    return replace(plan, placements=tuple(map(spread, plan.placements)))


class Attended:
    """A ballbar session; a person does what is asked, and skips poses where the arm was halted before."""

    def __init__(self, plan, book):
        self.plan, self.book = plan, book
        self.bench = ballbar.Bench(
            plan, look_at_ways=book.look, look_past_fixture=lambda *told: book.look(told[-1])
        )
        self.robot = Watched(self.bench.robot, book)
        self.robot.session = self
        moves = [step for step in steps(plan, KIT) if step.target_rad is not None]
        places = [moves[0].target_rad]
        for move in moves[1:]:
            places += [*move.via_rad, move.target_rad]
        book.allowed += pairwise(places)  # the plan was looked at when it was made

    async def _aim(self, plan, entries):
        """Lead to each pose that was skipped by a way that is looked at, from where the arm rested."""
        (place,) = plan.placements
        places = [[entry.arrival.commanded_rad for entry in entries if entry.arrival is not None][-1]]
        aimed = [replace(pose, via_rad=((0.1 * pose.config, *[0.2] * 5),)) for pose in place.poses]
        for pose in aimed:
            if POSE(pose.config) in self.skipped:
                places += [*pose.via_rad, pose.joints_rad]
        self.book.allowed += pairwise(places)
        return found(*aimed)

    async def to_the_end(self, happens, skipped):
        """Let these happen in the midst of the first motion of a step; then skip it where it is `skipped`."""
        self.bench.oracle.precalibrate, self.skipped = self._aim, skipped
        self.restart, hit = False, set()
        async with self.bench as bench:
            await bench.start()
            for _ in range(400):
                step = bench.present
                if has_ended(bench.now.state):
                    break
                if step in happens and step not in hit and bench.now.state is SessionState.RUNNING:
                    hit.add(step)
                    self.robot.at_motion = {len(self.book.gone): getattr(Watched, happens[step])}
                await self._deed(skip=step in hit and step in skipped and self.robot.at_motion == {})
                if len(self.book.gone) > max(self.robot.at_motion, default=0):
                    self.robot.at_motion = {}
        return bench.now.state

    async def _deed(self, *, skip):
        bench = self.bench
        if self.restart:
            self.restart = False
            await bench.restart()
        elif bench.now.state is not SessionState.RUNNING:
            self.book.answered(english(bench.now.question))
            await bench.press(CommandName.CONFIRM, step_id=None)
        elif skip:
            await bench.press(SKIP, reason="in the way")
        else:
            with contextlib.suppress(AssertionError):  # nothing happens: the program is dead
                await bench.do()


POSE = "placement-1/pose-{}/move".format
BALLBAR_ACTS = {
    "nothing": ({}, ()),
    "the link is lost": ({POSE(2): "lose_link"}, ()),
    "the link is lost on the way to a pose that is skipped": ({POSE(2): "lose_link"}, (POSE(2),)),
    "the same at the last pose, which is aimed anew": ({POSE(3): "lose_link"}, (POSE(3),)),
    "the same at two in a row": ({POSE(2): "lose_link", POSE(3): "lose_link"}, (POSE(2), POSE(3))),
    "a target is refused, and the pose skipped": ({POSE(2): "refuse"}, (POSE(2),)),
    "the program is killed": ({POSE(2): "die"}, ()),
    "the program is killed on the way to a pose that is skipped": ({POSE(3): "die"}, (POSE(3),)),
    "the program is killed on the way to the first cup": ({CUP: "die"}, ()),
}


@NARROW
@pytest.mark.parametrize(("happens", "skipped"), BALLBAR_ACTS.values(), ids=BALLBAR_ACTS)
async def test_a_session_with_a_ballbar_goes_no_way_that_nobody_looked_at(happens, skipped, narrow):
    book = Book(narrow=narrow)
    session = Attended(spread_plan((1, 2, 3), precalibrate_after=9), book)

    assert await session.to_the_end(happens, skipped) is SessionState.FINISHED

    assert book.unseen() == []
    assert len(book.gone) > 8
    assert book.strange == 1  # from where the arm stood at first; else as planned
