"""A cell with a ballbar, a person's hands and a robot that judges; all plain objects on one clock."""

import asyncio
import contextlib
import heapq
import math
from collections.abc import AsyncIterator, Callable
from itertools import count

from tests.unit.service.sessions.ballbar.sessions import KIT, found, joints, make_pose
from tests.unit.service.sessions.stand_ins import Controller, Device, FiniteDisk, nothing_in_the_way
from tests.unit.service.sessions.tracker.fakes import IRB120
from truepose.domain.ballbar import BallbarPlan, PreCalibration, StepKind, Suspicion
from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import JointRange
from truepose.domain.session import SessionState
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.cell import BallbarCell
from truepose.sessions.ballbar.length_check import Judges
from truepose.sessions.ballbar.runner import BallbarRunner
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.errors import ReasonMissingError
from truepose_drivers.api import BallbarReading, JointReading
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, DriverError

HOME = joints(0)
LIMITS = (JointRange(-1.0, 1.0),) * 6
_AWAKE_S = 1.5  # so long a ballbar that was let go shows its stop
_MOST_TURNS = 50  # of the event loop: more than any chain of tasks that wake each other is long


class Clock:
    """Stands still unless a test lets it go on; wakes sleepers in order."""

    def __init__(self) -> None:
        self.time_s = 1000.0
        self._sleepers: list[tuple[float, int, asyncio.Future[None]]] = []
        self._numbers = count()

    async def now_s(self) -> float:
        return self.time_s

    async def sleep(self, duration_s: float) -> None:
        woken = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (self.time_s + duration_s, next(self._numbers), woken))
        await woken

    async def advance(self, duration_s: float) -> None:
        until_s = self.time_s + duration_s
        await turns()
        while self._sleepers and self._sleepers[0][0] <= until_s + 1e-9:
            self.time_s, _, woken = heapq.heappop(self._sleepers)
            if not woken.done():
                woken.set_result(None)
                await turns()
        self.time_s = until_s


async def turns() -> None:
    """Let all other tasks run until each of them waits for the clock or for the test.

    Two that wait like this keep each other awake, hence the limit.
    """
    loop = asyncio.get_running_loop()
    for _ in range(_MOST_TURNS):
        await asyncio.sleep(0)
        if not loop._ready:
            return


class Hands:
    """Where the ballbar really is, as only the person knows."""

    def __init__(self, robot: "Robot") -> None:
        self._robot = robot
        self.at: tuple[str, tuple[int, int]] | None = None  # ("calibrator" | "side" | "leg", points)
        self.connections = 0
        self.offset_mm = 0.0  # added to every true deviation
        self.bars = ""  # "tool" or "base": what is screwed on
        self.connected_s = 0.0
        self.let_go_s = -math.inf
        self.sways = False  # held in the hand, near its range

    def connect(self, what: str, points: tuple[int, int] = (0, 0)) -> None:
        self.at = (what, points)
        self.sways = False
        self.connections += 1
        self.connected_s = self._robot.clock.time_s

    def detach(self) -> None:
        if self.at is not None or self.sways:
            self.let_go_s = self._robot.clock.time_s
        self.at = None
        self.sways = False

    def hold(self) -> None:
        """Take the ballbar in the hand, which plays with it within its range."""
        self.detach()
        self.sways = True

    def do_as_asked(self, step_id: str) -> None:
        """Connect the ballbar, or take it off, as a step asks."""
        match step_ids.kind_of(step_id):
            case StepKind.INITIALISE:
                self.bars = "tool" if step_id.startswith(step_ids.TOOL) else "base"
                self.connect("calibrator")
            case StepKind.MEASURE_SIDE:
                self.connect("side", step_ids.points_of(step_id))
            case StepKind.CONNECT_LEG:
                self.connect("leg", step_ids.points_of(step_id))
            case StepKind.DETACH:
                self.detach()
            case _:
                pass

    @property
    def deviation_mm(self) -> float:
        """Off the nominal length; every pair and every stop has its own."""
        if self.sways:
            return 0.7 * math.sin(2.0 * math.pi * self._robot.clock.time_s / 0.7)
        if self.at is None:
            return math.nan
        what, (a, b) = self.at
        if what == "calibrator":
            return (0.022 if self.bars == "tool" else 0.002) + self.offset_mm
        stop = self._robot.joints[0] if what == "leg" else 0.3
        return 0.8 * math.sin(7.0 * a + 3.0 * b + 11.0 * stop) + self.offset_mm


class Bar(Device):
    """A ballbar with a cable; its noise is a small pattern that repeats."""

    def __init__(self, clock: Clock, hands: Hands) -> None:
        super().__init__("Renishaw", "QC20-W", "B-7", "1")
        self._clock = clock
        self._hands = hands
        self.plugged = True
        self.lost = ConnectionLostError
        self.wobble_mm = 0.0003
        self.temperature_c: float | None = 22.5
        self.out_of_range_mm: float | None = None
        self.frozen = False  # it repeats its last count
        self.switched_on = True
        self.flagged = False  # it says out of range, whatever it reads
        self._samples = count()
        self._number = 0
        self.read_at: tuple[str, tuple[int, int]] | None = None  # where it was at the last reading

    async def connect(self) -> None:
        if not self.plugged:
            raise ConnectFailedError("no ballbar at this port; check the cable")
        await super().connect()

    async def read(self) -> BallbarReading:
        if not self.plugged or not self.connected:
            raise self.lost("the ballbar is gone; check the cable")
        self._number = number = self._number if self.frozen else next(self._samples)
        self.read_at = self._hands.at
        shown, signal = self._hands.deviation_mm, "good"
        asleep = self._clock.time_s - self._hands.let_go_s > _AWAKE_S
        if not self.switched_on or (math.isnan(shown) and asleep):
            shown, signal = math.nan, "none"
        elif math.isnan(shown):
            shown, signal = 1.05, "out_of_range"
        elif self.out_of_range_mm is not None:
            shown, signal = self.out_of_range_mm, "out_of_range"
        elif number % 2:
            shown += self.wobble_mm
        if self.flagged and signal == "good":
            signal = "out_of_range"
        return BallbarReading(shown, signal, 0.0001, self._clock.time_s, self.temperature_c, number)


class Robot(Controller):
    """Moves when told; the judge of every motion, since it alone sees what is really attached."""

    def __init__(self, clock: Clock) -> None:
        super().__init__()
        self.clock = clock
        self.joints = HOME
        self.plugged = True
        self.motion_s = 1.0
        self.state_age_s = 0.0
        self.judge: Callable[[], None] = lambda: None
        self.fault: DriverError | None = None  # of the next motion
        self.under_way = False
        self.told_s = -math.inf  # the time of its last statement where it is

    async def connect(self) -> None:
        if not self.plugged:
            raise ConnectFailedError("no robot at this address")
        await super().connect()

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        self.judge()
        self.moves.append(target_rad)
        if self.fault is not None:
            fault, self.fault = self.fault, None
            raise fault
        self.joints = target_rad  # also where the program dies on the way: the controller goes on
        self.under_way = True
        try:
            await self.clock.sleep(self.motion_s)
        finally:
            self.under_way = False

    async def read_joints(self) -> JointReading:
        if not self.plugged or not self.connected:
            self.connected = False
            raise ConnectionLostError("the link to the robot is down")
        self.told_s = self.clock.time_s - self.state_age_s
        return JointReading(self.joints, math.radians(0.01), self.told_s)


class Disk(FiniteDisk):
    """A ledger that keeps; a repeated key changes nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.entries: list[LedgerEntry] = []
        self.on_append: Callable[[LedgerEntry], None] = lambda entry: None

    async def append(self, entry: LedgerEntry) -> int:
        if self.full:
            raise RecordRefusedError("database or disk is full")
        for number, kept in enumerate(self.entries):
            if entry.key is not None and kept.key == entry.key:
                return number
        await asyncio.sleep(0)
        self.entries.append(entry)
        self.on_append(entry)
        number = len(self.entries) - 1
        await asyncio.sleep(0)  # kept, and nobody has been told yet
        return number


class Oracle:
    """Foresees by saying what a test wants."""

    def __init__(self) -> None:
        self.answer: PreCalibration | Exception | None = None
        self.asked = 0
        self.duration_s = 0.0
        self.clock: Clock | None = None

    async def precalibrate(self, plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
        self.asked += 1
        if self.clock is not None:
            await self.clock.sleep(self.duration_s)
        if isinstance(self.answer, Exception):
            raise self.answer
        poses = [pose for placement in plan.placements for pose in placement.poses]
        return self.answer or found(*(make_pose(p.config, p.placement) for p in poses))


class Suspect:
    """A judge of lengths that sees what is really connected."""

    def __init__(self, bar: Bar) -> None:
        self._bar = bar
        self.blind = False
        self.of_pose: tuple[Suspicion, ...] = ()

    def leg(self, asked, length_mm, earlier, forecast, **_) -> Suspicion | None:
        what, pair = self._bar.read_at or ("", (0, 0))
        if self.blind or (pair == asked and what != "calibrator"):
            return None
        return Suspicion("same_pair" if pair in earlier else "other_pair", asked, pair, length_mm, 300.0)

    def pose(self, lengths, forecast, **_) -> tuple[Suspicion, ...]:
        found, self.of_pose = self.of_pose, ()
        return found


class Bench:
    """A session on these fakes, with a person who does as asked unless a test does otherwise."""

    def __init__(
        self,
        plan: BallbarPlan,
        entries: tuple[LedgerEntry, ...] = (),
        judges: Judges | None = None,
        **cell,
    ) -> None:
        """Run `plan`; `cell` is what the session is told otherwise of its cell."""
        self.plan = plan
        self._judges = judges
        self.clock = Clock()
        self.robot = Robot(self.clock)
        self.hands = Hands(self.robot)
        self.bar = Bar(self.clock, self.hands)
        self.disk = Disk()
        self.disk.entries += entries
        self.oracle = Oracle()
        self.suspect = Suspect(self.bar)
        self.keys = count()
        known = {
            "ballbar": self.bar,
            "robot_controller": self.robot,
            "clock": self.clock,
            "robot": IRB120,
            "look_at_ways": nothing_in_the_way,
            "look_past_fixture": nothing_in_the_way,
            "joint_limits": LIMITS,
        }
        self.cell = BallbarCell(**known | cell)
        self.runner = self._runner()
        self.running: asyncio.Task[SessionState] | None = None

    def _runner(self) -> BallbarRunner:
        return BallbarRunner(
            self.plan,
            KIT,
            self.cell,
            self.disk,
            lambda *asked: self.oracle.precalibrate(*asked),
            tuple(self.disk.entries),
            judges=self._judges or Judges(self.suspect.leg, self.suspect.pose),
            wall_ms=lambda: int(1000 * self.clock.time_s),
            breath_s=0.0,
        )

    @contextlib.asynccontextmanager
    async def at(self, step_id: str) -> AsyncIterator["Bench"]:
        """Run the session, everything before a step done as it is asked."""
        async with self:
            await self.start()
            await self.until(step_id)
            yield self

    async def __aenter__(self) -> "Bench":
        self.running = asyncio.create_task(self.runner.run())
        await turns()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.kill()

    async def kill(self) -> None:
        """End the program as a lost supply does; the controller of the robot knows nothing of it."""
        if self.running is not None:
            self.running.cancel()
            await asyncio.gather(self.running, return_exceptions=True)

    async def restart(self) -> None:
        await self.kill()
        self.runner = self._runner()
        self.running = asyncio.create_task(self.runner.run())
        await turns()

    @property
    def now(self):
        return self.runner.situation

    @property
    def present(self) -> str | None:
        return self.now.step.id if self.now.step else None

    async def press(self, name: CommandName, **fields) -> CommandOutcome:
        act = {"person": "Eva", "tablet": "one", "key": f"key-{next(self.keys)}", "step_id": self.present}
        return await self.send(OperatorCommand(name, **{**act, **fields}))

    async def send(self, act: OperatorCommand) -> CommandOutcome:
        """Have an act done, and let time pass while it takes some."""
        sent = asyncio.create_task(self.runner.act(act))
        try:
            await turns()
            while not sent.done():
                await self.clock.advance(0.05)
            return sent.result()
        finally:
            if not sent.done():  # the program was killed in the middle of it
                sent.cancel()
                await asyncio.gather(sent, return_exceptions=True)
            elif not sent.cancelled():
                sent.exception()

    async def start(self) -> None:
        await self.press(CommandName.START, step_id=None)

    async def do(self) -> str | None:
        """Do the present step as it is asked for, and wait until the next one is there."""
        step_id = self.present
        assert step_id is not None
        await self.clear_hands(step_id)
        self.hands.do_as_asked(step_id)
        if CommandName.CONFIRM in self.now.acts:
            await self.confirm()
        for _ in range(60):
            if self.present != step_id or self.now.suspicion is not None:
                return step_id
            if self.now.state is not SessionState.RUNNING:
                return step_id
            await self.clock.advance(0.1)
        raise AssertionError(f"nothing happens at {step_id}")

    async def confirm(self) -> None:
        """Confirm the present step, and say where the ballbar lies where that is asked for."""
        try:
            await self.press(CommandName.CONFIRM)
        except ReasonMissingError:
            assert self.hands.at is None, "an honest person does not say that it is off"
            await self.press(CommandName.CONFIRM, reason="it lies on the table")

    async def replug(self, serial: str | None = None) -> None:
        """Pull the cable of the ballbar and plug it in again, into one of another serial number if any."""
        self.bar.plugged = False
        await self.clock.advance(1.0)
        self.bar.serial, self.bar.plugged = serial or self.bar.serial, True
        await self.clock.advance(5.0)

    async def clear_hands(self, step_id: str) -> None:
        """Take the ballbar out of its cups on the way to a new connection, as a person must."""
        if step_ids.kind_of(step_id) in READINGS and self.hands.at is not None:
            self.hands.detach()
            await self.clock.advance(0.1)

    async def until(self, step_id: str | None) -> None:
        while self.present != step_id:
            before = self.present
            await self.do()
            assert self.present != before, f"stuck at {before}"

    def kept(self, step_id: str, kind: EntryKind = EntryKind.MEASURED) -> list[LedgerEntry]:
        return [entry for entry in self.disk.entries if entry.step_id == step_id and entry.kind is kind]

    def states(self) -> list[SessionState]:
        return [entry.entered for entry in self.disk.entries if entry.entered is not None]
