"""Whatever persons do and whatever fails, in any order: nothing moves that must not, no reading is lost.

Sessions, each taken up somewhere in its middle by persons who press anything at any time on two
tablets, with requests that come twice, wrong connections, pulled cables, an arm that others move, and a
program that dies. Persons say at any time that the ballbar is off and that the cell is clear, and attach the
ballbar whenever they like, also after they said that it is off. They keep to two things only: nobody attaches
it within the last samples before the arm is sent on, and who gives a reason why it is off, where it cannot be
read, has taken it off and leaves it off until it can.
"""

import asyncio
import contextlib
import random
from collections import Counter

from tests.unit.service.sessions.ballbar.fakes import Bench, turns
from tests.unit.service.sessions.ballbar.sessions import LEGS, joints, make_plan, make_sphere_plan
from truepose.domain.ballbar import BallbarPlan, StepKind
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.state import READINGS, Answer
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import SessionError
from truepose_drivers.errors import ConnectionLostError, NoReplyError, TargetRefusedError

DEEDS = 14  # of a person in each session
PLAN = make_plan((1, 2), precalibrate_after=1, stable_s=0.1, settle_s=0.0)
SPHERE = make_sphere_plan(12, stable_s=0.1, settle_s=0.0)
SEEN_S = 0.16  # three samples: a ballbar attached that shortly before, from out of a hand, cannot be told
NEEDS_IT_OFF = {StepKind.DETACH, StepKind.MOVE}
NEWS = frozenset(EntryKind) - {EntryKind.CONTROL}
HALTS = frozenset({CommandName.PAUSE, CommandName.STOP, CommandName.ABORT})


def went_well(plan: BallbarPlan) -> tuple[LedgerEntry, ...]:
    """Return the ledger of a session in which all went well."""

    async def run() -> tuple[LedgerEntry, ...]:
        async with Bench(plan) as bench:
            await bench.start()
            await bench.until(None)
            return tuple(bench.disk.entries)

    return asyncio.run(run())


class Guard:
    """Looks at every motion and every line from outside, with what only an onlooker knows."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.motions = 0
        self.stops_open = 0
        self.retries = 0
        self.acknowledged: dict[int, str] = {}  # line -> key
        self.taken_by_itself: Counter[tuple[int, int]] = Counter()
        self.lies = 0  # that the ballbar is off while it is on
        self.wrong: list[str] = []
        bench.robot.judge = self.motion
        bench.disk.on_append = self.line

    def motion(self) -> None:
        self.motions += 1
        bench = self.bench
        last = next(entry for entry in reversed(bench.disk.entries) if self._matters(entry))
        is_move = step_ids.kind_of(last.step_id) is StepKind.MOVE
        unseen = bench.clock.time_s - bench.hands.connected_s < SEEN_S
        self._require(bench.hands.at is None or unseen, "the ballbar is attached")
        self._require(
            last.kind is EntryKind.CONFIRMED and is_move, f"{last.kind} of {last.step_id} came last"
        )
        self._require(bool(last.person) and last.key is not None, "no person confirmed")
        self._require(bench.clock.time_s - bench.robot.told_s <= 2.0, "the robot's statement is old")
        self._require(self.stops_open == 0, "stop was pressed")

    def line(self, entry: LedgerEntry) -> None:
        bench = self.bench
        if entry.kind not in {EntryKind.MEASURED, EntryKind.SUSPECTED} or entry.length is None:
            return
        if not entry.length.by_hand and entry.text != Answer.RIGHT_PAIR:
            self.taken_by_itself[bench.hands.connections, self.retries] += 1
        kind = step_ids.kind_of(entry.step_id)
        if kind is StepKind.CONNECT_LEG and entry.suspicion is None:
            asked = ("leg", step_ids.points_of(entry.step_id))
            self._require(bench.bar.read_at == asked, f"{bench.bar.read_at} was stored as {asked}")

    @staticmethod
    def _matters(entry: LedgerEntry) -> bool:
        return entry.kind in NEWS or entry.entered is not None

    def _require(self, true: bool, otherwise: str) -> None:
        if not true:
            self.wrong.append(otherwise)


class Crowd:
    """Two persons at two tablets, an electrician, and whoever else comes by."""

    def __init__(self, bench: Bench, guard: Guard, rng: random.Random) -> None:
        self.bench = bench
        self.guard = guard
        self.rng = rng
        self.pressed: list[OperatorCommand] = []

    async def deed(self) -> None:
        deeds = (
            (self.go_on, 24),
            (self.press_anything, 7),
            (self.press_two_at_once, 3),
            (self.connect_something, 6),
            (self.wait, 2),
            (self.repeat_a_request, 2),
            (self.trouble_with_the_ballbar, 1),
            (self.trouble_with_the_robot, 2),
            (self.kill, 1),
            (self.kill_in_the_middle_of_a_request, 2),
        )
        names, weights = zip(*deeds, strict=True)
        await self.rng.choices(names, weights)[0]()

    async def go_on(self) -> None:
        """Do what the page asks for."""
        bench = self.bench
        match bench.now.state:
            case SessionState.AWAITING_CONFIRMATION:
                if self.rng.random() < 0.9:  # most put right what is asked to be put right
                    bench.robot.plugged, bench.robot.state_age_s, bench.robot.fault = True, 0.0, None
                await self.press(CommandName.CONFIRM)
            case SessionState.PAUSED:
                await self.press(CommandName.RESUME)
            case _ if bench.now.suspicion is not None:
                await self.press(CommandName.ANSWER)
            case _ if CommandName.CONFIRM in bench.now.acts:
                await self.press(CommandName.CONFIRM)
                await bench.clock.advance(self.rng.choice((0.1, 0.9)))
                if self.rng.random() < 0.1:  # while the arm moves, perhaps
                    await self.connect_something()
            case _:
                self.attach()
                await bench.clock.advance(self.rng.choice((0.06, 0.25)))
                if self.rng.random() < 0.3 and CommandName.STORE in bench.now.acts:
                    await self.press(CommandName.STORE)

    def attach(self) -> None:
        """Connect what is asked for, where it can be read and something is asked for."""
        now = self.bench.now
        reads = now.step is not None and now.step.kind in READINGS
        if now.state is SessionState.RUNNING and now.shown and reads and self.can_be_read:
            self.bench.hands.do_as_asked(now.step.id)

    async def connect_something(self) -> None:
        """Attach the ballbar somewhere, asked for or not, unless it cannot be read."""
        if self.can_be_read:
            what = self.rng.choice(("leg", "calibrator"))
            self.bench.hands.connect(what, (0, 0) if what == "calibrator" else self.rng.choice(LEGS))
        await self.bench.clock.advance(self.rng.choice((0.05, 0.3)))

    async def press_anything(self) -> None:
        sensible = sorted(self.bench.now.acts) or [*CommandName]
        await self.press(self.rng.choice(sensible if self.rng.random() < 0.7 else [*CommandName]))
        await self.bench.clock.advance(self.rng.choice((0.0, 0.1, 0.6)))

    async def press_two_at_once(self) -> None:
        likely = (
            CommandName.CONFIRM,
            CommandName.STOP,
            CommandName.BACK,
            CommandName.SKIP,
            CommandName.STORE,
        )
        await asyncio.gather(*(self.press(self.rng.choice(likely)) for _ in range(2)))
        await self.bench.clock.advance(self.rng.choice((0.0, 0.6)))

    async def wait(self) -> None:
        await self.bench.clock.advance(self.rng.choice((0.3, 1.0)))

    async def repeat_a_request(self) -> None:
        if self.pressed:
            await self.send(self.rng.choice(self.pressed))

    async def press(self, name: CommandName) -> None:
        if name is CommandName.ABORT and self.rng.random() < 0.8:
            return
        await self.send(self.act(name))

    def act(self, name: CommandName) -> OperatorCommand:
        bench, rng = self.bench, self.rng
        if name is CommandName.RETRY:
            self.guard.retries += 1
        acting = bench.now.acting.tablet if bench.now.acting else "one"
        tablet = acting if rng.random() < 0.9 else rng.choice(("one", "two"))
        step_id = bench.present if rng.random() < 0.95 else "placement-1/pose-1/leg-1-1"
        answer = rng.choice([*Answer]).value
        act = OperatorCommand(name, "Eva", tablet, f"crowd-{next(bench.keys)}", step_id, "a reason", answer)
        self.pressed.append(act)
        return act

    async def send(self, act: OperatorCommand) -> None:
        bench, guard = self.bench, self.guard
        if act.name is CommandName.CONFIRM and step_ids.kind_of(act.step_id or "") in NEEDS_IT_OFF:
            self.take_off()
        stops = act.name is CommandName.STOP and bench.now.state is SessionState.RUNNING
        stops = stops and not any(entry.key == act.key for entry in bench.disk.entries)
        guard.stops_open += stops
        try:
            with contextlib.suppress(SessionError):
                outcome = await bench.send(act)
                if english(outcome.sentence).startswith("Stored"):
                    guard.acknowledged[outcome.entry] = act.key
        finally:
            guard.stops_open -= stops

    def take_off(self) -> None:
        """Take the ballbar off before one says so, or forget to where it can be read."""
        hands = self.bench.hands
        if not self.can_be_read or self.rng.random() < 0.7:
            self.rng.choice((hands.detach, hands.detach, hands.hold))()
        self.guard.lies += hands.at is not None

    @property
    def can_be_read(self) -> bool:
        return self.bench.bar.plugged and self.bench.bar.connected

    async def trouble_with_the_ballbar(self) -> None:
        self.bench.bar.plugged = False
        self.bench.bar.lost = self.rng.choice((NoReplyError, ConnectionLostError))
        await self.bench.clock.advance(0.3)
        self.bench.bar.plugged = True
        await self.bench.clock.advance(0.6)

    async def trouble_with_the_robot(self) -> None:
        robot = self.bench.robot
        match self.rng.randrange(5):
            case 0:
                robot.plugged = not robot.plugged
            case 1 | 2:
                robot.state_age_s = self.rng.choice((1.0, 2.5, 60.0))
            case 3:
                robot.joints = joints(self.rng.randrange(5))  # by somebody with the pendant
                self.guard.retries += 1  # what is connected has another length now
            case _:
                robot.fault = self.rng.choice((ConnectionLostError("cut"), TargetRefusedError("joint 2")))
        await self.bench.clock.advance(0.6)

    async def kill(self) -> None:
        await self.bench.restart()

    async def kill_in_the_middle_of_a_request(self) -> None:
        """The tablet has no answer, so it sends the same request again once the service is back."""
        likely = [name for name in self.bench.now.acts if name is not CommandName.ABORT] or [CommandName.STOP]
        act = self.act(self.rng.choice(sorted(likely)))
        sent = asyncio.create_task(self.send(act))
        for _ in range(self.rng.randrange(8)):
            await asyncio.sleep(0)
        await self.bench.kill()
        sent.cancel()
        await asyncio.gather(sent, return_exceptions=True)
        await self.bench.restart()
        await self.send(act)


async def random_session(plan: BallbarPlan, whole: tuple[LedgerEntry, ...], seed: int) -> Guard:
    rng = random.Random(seed)
    begun = whole[: rng.randrange(len(whole))] if seed % 10 else ()
    bench = Bench(plan, begun)
    guard = Guard(bench)
    bench.robot.motion_s = 0.1
    arrived = [entry.arrival for entry in begun if entry.arrival is not None]
    bench.robot.joints = arrived[-1].reported_rad if arrived else bench.robot.joints
    async with bench:
        crowd = Crowd(bench, guard, rng)
        if not begun:
            await crowd.press(CommandName.START)
        for _ in range(DEEDS):
            if bench.running.done():
                break
            await crowd.deed()
        await turns()
        if bench.running.done():
            bench.running.result()
    return guard


def lost(guard: Guard) -> list[str]:
    """Return what was acknowledged and is not there."""
    entries = guard.bench.disk.entries
    return [
        key
        for number, key in guard.acknowledged.items()
        if entries[number].key != key or entries[number].kind is not EntryKind.MEASURED
    ]


def doubled(entries: list[LedgerEntry]) -> list[str]:
    """Return the steps that were measured while a reading of theirs counted already."""
    counts: set[str] = set()
    found = []
    for entry in entries:
        if entry.kind is EntryKind.REOPENED:
            takes_along = entry.step_id.rsplit("/", 1)[-1] in {"move", "initialise"}
            group = entry.step_id.rpartition("/")[0] + "/" if takes_along else entry.step_id
            counts = {step_id for step_id in counts if not step_id.startswith(group)}
        if entry.kind is EntryKind.MEASURED:
            is_a_zero_in_between = step_ids.kind_of(step_ids.group_of(entry.step_id)) is not None
            if entry.step_id in counts and not is_a_zero_in_between:
                found.append(entry.step_id)
            counts.add(entry.step_id)
    return found


def require_safe(plan: BallbarPlan, whole: tuple[LedgerEntry, ...], seeds: range) -> None:
    """Run a session of each seed, and hold each against what must never happen."""
    motions = lies = 0
    for seed in seeds:
        guard = asyncio.run(random_session(plan, whole, seed))

        assert guard.wrong == [], f"seed {seed}"
        assert lost(guard) == [], f"seed {seed}"
        assert doubled(guard.bench.disk.entries) == [], f"seed {seed}"
        assert not guard.taken_by_itself or max(guard.taken_by_itself.values()) == 1, f"seed {seed}"
        motions += guard.motions
        lies += guard.lies

    assert motions > 0 and lies > 0  # else this test could not fail
