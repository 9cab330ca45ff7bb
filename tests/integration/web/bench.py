"""A cell whose devices answer at once: a tracker that sees whatever it looks at, a robot that is there."""

import asyncio

from tests.helpers.domain.builders import make_campaign
from tests.helpers.web.clients import command
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose_drivers.api import (
    BallbarReading,
    DeviceIdentity,
    DriverPlugin,
    Environment,
    JointReading,
    MotionGuard,
    TrackerReading,
)
from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError, NotInitialisedError
from truepose_drivers.registry import DriverRegistry

CELL = """
name = "bench"
robot = "abb-irb-120"
robot_serial_number = "120-1"

[[fixed_nest]]
centre_mm = [600.0, -500.0, 0.0]
u_mm = 0.002
[[fixed_nest]]
centre_mm = [600.0, 500.0, 0.0]
u_mm = 0.002
[[fixed_nest]]
centre_mm = [-350.0, 500.0, 0.0]
u_mm = 0.002

[tracker]
position_mm = [2600.0, -700.0, 500.0]
fixed_nests_seen_mm = [[600.0, -500.0, 0.0], [600.0, 500.0, 0.0], [-350.0, 500.0, 0.0]]

[[device]]
name = "tracker"
driver = "fake_tracker"
certificate = "report 7"

[[device]]
name = "robot"
driver = "fake_robot"
"""


class FakeClock:
    """Time passes when somebody waits, and costs nothing."""

    def __init__(self):
        self.time_s = 0.0

    async def now_s(self):
        return self.time_s

    async def sleep(self, duration_s):
        self.time_s += duration_s
        await asyncio.sleep(0)


class FakeLink:
    """A link that opens unless it is told to be dead."""

    def __init__(self, model, serial="42"):
        self.serial = serial
        self.connected = False
        self.dead = False
        self._model = model

    async def connect(self):
        if self.dead:
            raise ConnectFailedError("Nobody answers at 192.0.2.1:700; check power, cable and address.")
        self.connected = True

    async def close(self):
        self.connected = False

    async def identify(self):
        return DeviceIdentity("ACME", self._model, self.serial, "1.0")


class FakeTracker(FakeLink):
    """Stands in the world's frame and measures the point that it was last sent to."""

    def __init__(self, clock):
        super().__init__("T1")
        self._clock = clock
        self._aimed_at = None
        self._face = 1
        self._initialised = False

    async def initialise(self):
        self._initialised = True

    async def find_reflector(self, near_mm, *, search_radius_mm):
        if not self._initialised:
            raise NotInitialisedError("initialise first")
        self._aimed_at = tuple(near_mm)

    async def measure_point(self, *, duration_s):
        await self._clock.sleep(duration_s)
        return TrackerReading(
            self._aimed_at, (0.01,) * 3, 0.01, 100, duration_s, self._face, self._clock.time_s
        )

    async def change_face(self):
        self._face = 3 - self._face

    async def environment(self):
        return Environment(23.0, 1013.0, 40.0)


class FakeRobot(FakeLink):
    """Arrives exactly where it is sent; `gate` holds every motion until it is set."""

    can_stop_motion = False
    motion_guard = MotionGuard()

    def __init__(self, clock):
        super().__init__("R1", "120-1")
        self._clock = clock
        self._joints_rad = (0.0,) * 6
        self.gate = asyncio.Event()
        self.gate.set()
        self.sent = asyncio.Event()
        self.moves = 0

    async def set_limits(self, limits):
        pass

    async def move_joints(self, target_rad):
        self.sent.set()
        await self.gate.wait()
        await self._clock.sleep(2.0)
        self.moves += 1
        self._joints_rad = tuple(target_rad)

    async def read_joints(self):
        return JointReading(self._joints_rad, 1e-4, self._clock.time_s)


class FakeBallbar(FakeLink):
    """Shows one deviation whatever it is attached to, with one sample each time it is asked."""

    def __init__(self, clock):
        super().__init__("L1")
        self._clock = clock
        self.deviation_mm = 0.0

    async def read(self):
        await asyncio.sleep(0.001)  # a counter takes its time; the clock of the bench does not
        return BallbarReading(self.deviation_mm, "good", 1e-4, self._clock.time_s, 23.0)


class FakeHands(FakeLink):
    """Remembers what it was asked to do; refuses what it is told to."""

    def __init__(self):
        super().__init__("H1")
        self.done = []
        self.refusal = None

    async def do(self, action, details):
        if self.refusal is not None:
            raise DeviceRefusedError(self.refusal)
        self.done.append((action, dict(details)))


class Bench:
    """The devices of one test, and the drivers that open them."""

    def __init__(self):
        self.clock = FakeClock()
        self.ballbar = FakeBallbar(self.clock)
        self.hands = FakeHands()
        self.tracker = FakeTracker(self.clock)
        self.robot = FakeRobot(self.clock)

    def registry(self):
        plugins = (
            DriverPlugin("monotonic_clock", "clock", "none", {}, lambda options, clock: self.clock),
            DriverPlugin("fake_tracker", "tracker", "fake", {}, lambda options, clock: self.tracker),
            DriverPlugin("fake_robot", "robot", "fake", {}, lambda options, clock: self.robot),
            DriverPlugin("fake_ballbar", "ballbar", "fake", {}, lambda options, clock: self.ballbar),
            DriverPlugin("fake_hands", "hands", "fake", {}, lambda options, clock: self.hands),
        )
        return DriverRegistry({plugin.name: plugin for plugin in plugins}, {})


def stops(n):
    """Return n harmless stops, within every limit of the robot and above its table."""
    joints = [[2.0 * k, 40.0, -30.0 + 0.25 * k, 0.0, 30.0, 0.0] for k in range(n)]
    return [{"config": k + 1, "joints_deg": q, "nest": 1} for k, q in enumerate(joints)]


def session_request(n=3, **changes):
    given = {"name": "left arm", "role": "calibration", "plan": {"method": "given", "stops": stops(n)}}
    return {**given, "registration_readings": 2, **changes}


SESSIONS = "/api/v1/sessions"
ZIP = {"Content-Type": "application/zip"}


async def planned(client, n=3, **changes):
    """Plan a session and return its path."""
    answer = await client.post(SESSIONS, json=session_request(n, **changes))
    assert answer.status_code == 201, answer.text
    return answer.headers["Location"]


async def begun(client, n=3, **changes):
    """Return the path of a session that a person has let begin."""
    path = await planned(client, n, **changes)
    await command(client, path, "start")
    await command(client, path, "confirm")
    return path


async def measured(client, until, n=3, **changes):
    """Return the path of a session that has finished."""
    path = await begun(client, n, **changes)
    await until(path, "state", "finished")
    return path


def number_of(path):
    """Return the number of a record at the end of its address."""
    return int(path.rsplit("/", 1)[1])


async def uploaded(client, **changes):
    """Bring a campaign and return its number."""
    archive = write_campaign_zip(make_campaign(**changes))
    return (await client.post("/api/v1/campaigns", content=archive, headers=ZIP)).json()["id"]
