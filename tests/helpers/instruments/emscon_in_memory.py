"""An emScon server that lives in memory: it answers from a script and remembers what it was asked."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.leica_emscon.driver import LaserTracker
from truepose_drivers.leica_emscon.instrument import TimeOuts
from truepose_drivers.leica_emscon.protocol import (
    RESULTS,
    Answer,
    Command,
    FrameReader,
    PacketType,
    Record,
    Request,
    Result,
    ResultStatus,
    decode_request,
    encode,
    exchange,
)

Answering = Callable[[Request], list[object]]
Script = dict[int, Answering]

# the fake answers at once or never
SILENT = TimeOuts(initialise_s=0.05, command_s=0.05, result_s=0.05)
HANG_UP = object()


@dataclass(frozen=True)
class Slow:
    """Packets that come after so long; what is asked meanwhile is answered that the server is busy."""

    after_s: float
    packets: list[object]


def answer(command: int, **values) -> Answer:
    filled = exchange(command).answer.zeros() | values
    return Answer(command, ResultStatus.ALL_OK, Record(filled))


def single(packet_type: int = PacketType.SINGLE_MEAS_RESULT_2, status: int = 0, **values) -> Result:
    return Result(packet_type, Record(RESULTS[packet_type].zeros() | values), status)


def point(**changes) -> Result:
    """A result at (1, 2, 3)."""
    return single(**({"val1": 1.0, "val2": 2.0, "val3": 3.0} | changes))


def told(**values) -> Answering:
    """Answer whatever is asked with these members."""
    return lambda request: [answer(request.command, **values)]


def refused(status: int = ResultStatus.NOT_IMPLEMENTED) -> Answering:
    """Answer whatever is asked with a status."""
    return lambda request: [Answer(request.command, status)]


def answered(*packets: object) -> Answering:
    """Answer whatever is asked, then say these."""
    return lambda request: [answer(request.command), *packets]


def reflector(number: int, name: str, total: int = 1, **values) -> Answer:
    return answer(
        Command.GET_REFLECTORS,
        total_reflectors=total,
        internal_reflector_id=number,
        reflector_name=name,
        **values,
    )


def as_set(request: Request) -> list[object]:
    """Answer a question with what was set, where the tracker remembers it; with zeros otherwise."""
    return [answer(request.command)]


def healthy() -> Script:
    """A tracker that is started up, knows one reflector and measures (1, 2, 3)."""
    script: Script = dict.fromkeys(Command, as_set)
    script[Command.GET_SYSTEM_STATUS] = told(
        tracker_processor_status=5,
        major_version_number=3,
        minor_version_number=6,
        build_number=1045,
        tracker_serial_number=392_001,
    )
    script[Command.GET_TRACKER_INFO] = told(tracker_type=70, tracker_name="AT401")
    script[Command.GET_CURRENT_PRISM_POSITION] = told(val1=1.0, val2=2.0, val3=3.0)
    script[Command.GET_REFLECTORS] = lambda _: [reflector(7, "RRR 0.5in")]
    script[Command.GET_FACE] = told(tracker_face=1)
    script[Command.START_MEASUREMENT] = answered(point(std1=0.001, std2=0.002, std3=0.003, std_total=0.004))
    return script


class FakeTracker:
    """Answers each request from a script and records what it was asked."""

    def __init__(self, script: Script | None = None, *, hello: tuple[object, ...] = ()) -> None:
        self.script = script or healthy()
        self.hello = hello
        self.requests: list[Request] = []
        self.dies_at: int | None = None  # with this command and ever after it says nothing
        self.says_busy = True
        self._dead = False
        self._busy = False
        self.kept: dict[int, Record] = {Command.GET_REFLECTOR: Record(internal_reflector_id=7)}

    def answers(self, request: Request) -> list[object]:
        name = Command(request.command).name
        if name.startswith("SET_") and f"GET_{name[4:]}" in Command.__members__:
            self.kept[Command[f"GET_{name[4:]}"]] = request.values
        if self.script[request.command] is as_set and request.command in self.kept:
            return [answer(request.command, **self.kept[request.command])]
        return self.script[request.command](request)

    async def serve(self, end: MemoryEnd) -> None:
        reader = FrameReader()
        for packet in self.hello:
            await end.send(encode(packet))
        while data := await end.receive():
            reader.receive_data(data)
            while (frame := reader.next_message()) is not None:
                request = decode_request(frame)
                self.requests.append(request)
                if await self._answer(end, request) is HANG_UP:
                    return

    async def _answer(self, end: MemoryEnd, request: Request) -> object:
        self._dead = self._dead or request.command == self.dies_at
        if self._dead:
            return None
        if self._busy:
            if self.says_busy:
                await end.send(encode(Answer(request.command, ResultStatus.SERVER_BUSY)))
            return None
        for packet in self.answers(request):
            if packet is HANG_UP:
                return HANG_UP
            if isinstance(packet, Slow):
                self._busy = True
                self._later = asyncio.create_task(self._send_later(end, packet))
            else:
                await end.send(packet if isinstance(packet, bytes) else encode(packet))
        return None

    async def _send_later(self, end: MemoryEnd, slow: Slow) -> None:
        await asyncio.sleep(slow.after_s)
        self._busy = False
        for packet in slow.packets:
            await end.send(encode(packet))

    def asked(self, command: int) -> list[Request]:
        return [request for request in self.requests if request.command == command]


def tracker_on(fake: FakeTracker, **options) -> LaserTracker:
    options.setdefault("time_outs", SILENT)
    chunk_bytes = options.pop("chunk_bytes", 65_536)
    return LaserTracker(MemoryLink(fake.serve, chunk_bytes=chunk_bytes), FixedClock(), **options)


async def ready_tracker(fake: FakeTracker, **options) -> LaserTracker:
    tracker = tracker_on(fake, **options)
    await tracker.connect()
    await tracker.initialise()
    return tracker
