"""The driver of an instrument bridge, against one that lives in memory and speaks lines written by hand."""

import asyncio
import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import PointTracker, PoseTracker
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    BeamBrokenError,
    BusyError,
    ConfigurationError,
    DeviceRefusedError,
    ImplausibleReadingError,
    NoReplyError,
    NotInitialisedError,
    OutOfVolumeError,
    ReflectorNotFoundError,
    RemoteProtocolError,
)
from truepose_drivers.framing import JsonLineError, LineReader
from truepose_drivers.guard import guarded
from truepose_drivers.json_bridge import driver
from truepose_drivers.json_bridge.driver import BridgedTracker, point_of, pose_of
from truepose_drivers.json_bridge.protocol import (
    Answer,
    Busy,
    Failure,
    Question,
    decode_question,
    decode_reply,
    encode_question,
    encode_reply,
)

pytestmark = pytest.mark.simulated_time

README = Path(driver.__file__).parent / "README.md"
# as docs and README write them out: what comes over the line, and what it means
GOLDEN = [
    (b'{"id": 1, "ask": "hello"}\n', Question(1, "hello")),
    (
        b'{"id": 7, "ask": "find_reflector", "near_mm": [2000.0, 300.0, -150.0], "radius_mm": 10.0}\n',
        Question(7, "find_reflector", {"near_mm": [2000.0, 300.0, -150.0], "radius_mm": 10.0}),
    ),
    (b'{"id": 7, "busy": true}\n', Busy(7)),
    (
        b'{"id": 7, "error": "beam_broken", "sentence": "clear the beam"}\n',
        Failure(7, "beam_broken", "clear the beam"),
    ),
    (
        b'{"id": 8, "serial": "12345", "unit": "mm", "sequence": 17, "point_mm": [1.0, 2.0, 3.0]}\n',
        Answer(8, "12345", {"unit": "mm", "sequence": 17, "point_mm": [1.0, 2.0, 3.0]}),
    ),
]
HELLO = {"serial": "12345", "version": 1, "manufacturer": "FARO", "model": "Vantage", "firmware": "6.1"}
READY = {"serial": "12345", "sequence": 10, "settings": "The tracker measures an SMR."}
POINT = {
    "serial": "12345",
    "unit": "mm",
    "sequence": 11,
    "point_mm": [2000.0, 300.0, -150.0],
    "deviation_mm": [0.003, 0.004, 0.0],
}
POSE = {
    "serial": "12345",
    "unit": "mm",
    "sequence": 11,
    "position_mm": [2000.0, 300.0, -150.0],
    "quaternion": [0.5, -0.5, 0.5, 0.5],
}
HANG_UP = object()


class FakeBridge:
    """Answers each kind of question by what `says` has for it: a document, bytes, or a list of things."""

    def __init__(self, **says) -> None:
        self.says = {"hello": HELLO, "initialise": READY, "find_reflector": {"serial": "12345"}, **says}
        self.asked = []
        self.count = 10

    async def serve(self, end: MemoryEnd) -> None:
        lines = LineReader()
        while data := await end.receive():
            lines.receive_data(data)
            while (line := lines.next_message()) is not None:
                question = json.loads(line)
                self.asked.append(question)
                said = self.says.get(question["ask"], {"serial": "12345"})
                for thing in said if isinstance(said, list) else [said]:
                    if thing is HANG_UP:
                        return
                    await self._say(end, question["id"], thing)

    async def _say(self, end: MemoryEnd, number: int, thing: object) -> None:
        if isinstance(thing, float):
            await asyncio.sleep(thing)
        elif isinstance(thing, bytes):
            await end.send(thing)
        else:
            await end.send(json.dumps({"id": number, **self._counted(thing)}).encode() + b"\n")

    def _counted(self, document):
        """Count on, where the document does not say what is counted."""
        if document.get("sequence") != 11:
            return document
        self.count += 1
        return {**document, "sequence": self.count}


def tracker_on(bridge: FakeBridge, **options) -> BridgedTracker:
    return BridgedTracker(MemoryLink(bridge.serve, **options), FixedClock())


async def ready(bridge: FakeBridge, **options) -> BridgedTracker:
    tracker = tracker_on(bridge, **options)
    await tracker.connect()
    await tracker.initialise()
    return tracker


@pytest.fixture
def bridge():
    return FakeBridge(measure_point=POINT)


@pytest.fixture
async def tracker(bridge):
    return await ready(bridge)


@pytest.mark.parametrize(("line", "message"), GOLDEN)
def test_lines_written_by_hand_are_met_byte_for_byte(line, message):
    if isinstance(message, Question):
        assert encode_question(message) == line
        assert decode_question(line) == message
    else:
        assert encode_reply(message) == line
        assert decode_reply(line) == message


def test_the_lines_of_the_readme_are_questions_and_replies():
    text = README.read_text()
    questions, replies = (block.strip().splitlines() for block in text.split("```")[1::2])

    asked = [decode_question(line.encode()) for line in questions]
    said = [decode_reply(line.encode()) for line in replies]

    assert [question.number for question in asked] == [1, 2, 3, 4, 5, 6, 7]
    assert [reply.number for reply in said] == [1, 2, 3, 3, 4, 5, 6, 7]
    assert point_of(said[4].values).point_mm == (2000.01, 300.02, -150.0)
    assert pose_of(said[5].values).quaternion == (0.5, -0.5, 0.5, 0.5)


@given(
    line=st.binary(max_size=60)
    | st.text(alphabet='{}[]":,0123456789.eE-+ idserialbusyerrornull').map(str.encode)
)
def test_hostile_lines_are_replies_or_protocol_errors(line):
    for decode in (decode_reply, decode_question):
        try:
            decode(line)
        except JsonLineError as error:
            assert str(error)


@pytest.mark.parametrize("chunk_bytes", [1, 7, 4096])
async def test_a_point_is_what_the_bridge_said(chunk_bytes):
    stated = {"covariance_mm2": [4e-6, 9e-6, 1e-6, 1e-7, 0.0, 0.0], "samples": 50, "face": 2, "rms_mm": 0.006}
    tracker: PointTracker = guarded(
        "json_bridge",
        "tracker",
        await ready(FakeBridge(measure_point=POINT | stated), chunk_bytes=chunk_bytes),
    )

    reading = await tracker.measure_point(duration_s=2.0)

    assert reading.point_mm == (2000.0, 300.0, -150.0)
    assert reading.standard_deviation_mm == (0.003, 0.004, 0.0)
    assert (reading.rms_mm, reading.samples, reading.face) == (0.006, 50, 2)
    assert reading.covariance_mm2 == ((4e-6, 1e-7, 0.0), (1e-7, 9e-6, 0.0), (0.0, 0.0, 1e-6))
    assert (reading.duration_s, reading.time_s) == (2.0, 12.5)


async def test_what_a_bridge_does_not_say_of_a_point_is_not_made_up(tracker):
    reading = await tracker.measure_point(duration_s=2.0)

    assert reading.rms_mm == pytest.approx(0.005)  # of the deviations
    assert (reading.samples, reading.face, reading.covariance_mm2) == (1, 1, None)


async def test_a_pose_is_what_the_bridge_said():
    stated = {
        "rotation_deviation_rad": 1e-4,
        "rms_mm": 0.02,
        "frames": 60,
        "deviation_mm": [0.01, 0.02, 0.03],
    }
    tracker: PoseTracker = guarded(
        "json_bridge", "pose_tracker", await ready(FakeBridge(measure_pose=POSE | stated))
    )

    reading = await tracker.measure_pose(duration_s=1.0)

    assert reading.quaternion == (0.5, -0.5, 0.5, 0.5)
    assert reading.position_mm == (2000.0, 300.0, -150.0)
    assert reading.position_deviation_mm == (0.01, 0.02, 0.03)
    assert (reading.rotation_deviation_rad, reading.rms_mm, reading.frames) == (1e-4, 0.02, 60)


async def test_what_a_bridge_does_not_say_of_a_pose_is_not_made_up():
    tracker = await ready(FakeBridge(measure_pose=POSE))

    reading = await tracker.measure_pose(duration_s=1.0)

    assert all(
        map(math.isnan, (*reading.position_deviation_mm, reading.rotation_deviation_rad, reading.rms_mm))
    )
    assert reading.frames == 1


async def test_it_says_who_is_behind_it_and_what_that_measures_with():
    tracker = tracker_on(FakeBridge())
    await tracker.connect()

    identity = await tracker.identify()
    await tracker.initialise()

    assert (identity.manufacturer, identity.model) == ("FARO", "Vantage")
    assert (identity.serial, identity.firmware) == ("12345", "6.1")
    assert tracker.settings == "The tracker measures an SMR."


async def test_the_questions_carry_their_numbers():
    bridge = FakeBridge(measure_point=POINT, environment={"serial": "12345", "temperature_c": 21.5})
    tracker = await ready(bridge)

    await tracker.find_reflector((1.0, 2.0, 3.0), search_radius_mm=10.0)
    await tracker.measure_point(duration_s=2.0)
    await tracker.change_face()
    air = await tracker.environment()

    assert [question["id"] for question in bridge.asked] == [1, 2, 3, 4, 5, 6]
    assert bridge.asked[2] == {
        "id": 3,
        "ask": "find_reflector",
        "near_mm": [1.0, 2.0, 3.0],
        "radius_mm": 10.0,
    }
    assert bridge.asked[3] == {"id": 4, "ask": "measure_point", "duration_s": 2.0}
    assert air.temperature_c == 21.5
    assert math.isnan(air.pressure_hpa)


@pytest.mark.parametrize(
    ("word", "error"),
    [
        ("beam_broken", BeamBrokenError),
        ("reflector_not_found", ReflectorNotFoundError),
        ("artefact_not_seen", ArtefactNotSeenError),
        ("out_of_volume", OutOfVolumeError),
        ("not_initialised", NotInitialisedError),
        ("busy", BusyError),
        ("refused", DeviceRefusedError),
        ("a word of its own", DeviceRefusedError),
    ],
)
async def test_what_cannot_be_done_is_told_in_the_bridges_sentence_and_leaves_the_link_open(word, error):
    bridge = FakeBridge(measure_point={"error": word, "sentence": "clear the beam, then repeat"})
    tracker = await ready(bridge)

    with pytest.raises(error, match="clear the beam"):
        await tracker.measure_point(duration_s=1.0)
    assert tracker.connected

    bridge.says["measure_point"] = POINT
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (2000.0, 300.0, -150.0)


async def test_a_bridge_that_says_that_it_is_at_work_is_waited_for():
    at_work = [thing for _ in range(50) for thing in ({"busy": True}, 1.0)]
    tracker = await ready(FakeBridge(measure_point=[*at_work, POINT]))

    assert (await tracker.measure_point(duration_s=1.0)).samples == 1


async def test_being_at_work_that_is_said_behind_the_answer_disturbs_nothing():
    tracker = await ready(FakeBridge(measure_point=[POINT, {"busy": True}]))

    for _ in range(3):
        assert (await tracker.measure_point(duration_s=1.0)).samples == 1


async def test_a_bridge_that_is_at_work_for_ever_is_given_up():
    at_work = [thing for _ in range(100) for thing in ({"busy": True}, 1.0)]
    tracker = await ready(FakeBridge(measure_point=at_work))

    with pytest.raises(NoReplyError, match="measure_point"):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


@pytest.mark.parametrize("ask", ["initialise", "find_reflector", "measure_point", "environment"])
async def test_silence_is_told_within_two_seconds(bridge, tracker, ask):
    bridge.says[ask] = []
    uses = {
        "initialise": tracker.initialise,
        "find_reflector": lambda: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0),
        "measure_point": lambda: tracker.measure_point(duration_s=30.0),
        "environment": tracker.environment,
    }
    begun_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match=ask):
        await uses[ask]()

    assert asyncio.get_running_loop().time() - begun_s <= 2.0
    assert not tracker.connected


@pytest.mark.parametrize(
    "changes",
    [
        {"unit": "inch"},
        {"unit": None},
        {"sequence": 10},  # said already when it was made ready
        {"sequence": "12"},
        {"sequence": None},
        {"point_mm": [1.0, 2.0]},
        {"point_mm": [1.0, 2.0, None]},
        {"point_mm": [1.0, 2.0, True]},
        {"point_mm": "1 2 3"},
        {"point_mm": [1e999, 2.0, 3.0]},
        {"deviation_mm": None},  # nor rms_mm: how much did it scatter?
        {"samples": 0},
        {"samples": 1.5},
        {"face": 3},
        {"face": True},
        {"covariance_mm2": [1.0, 1.0, 1.0]},
        {"serial": ""},
        {"serial": None},
    ],
)
async def test_an_answer_that_is_no_point_closes_the_link(changes):
    tracker = await ready(FakeBridge(measure_point=POINT | changes))

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


async def test_a_point_that_no_tracker_reaches_is_no_reading():
    far = FakeBridge(measure_point=POINT | {"point_mm": [1e7, 0.0, 0.0]})
    tracker = guarded("json_bridge", "tracker", await ready(far))

    with pytest.raises(ImplausibleReadingError, match="farther"):
        await tracker.measure_point(duration_s=1.0)


async def test_a_measurement_that_comes_again_is_frozen_also_after_connecting_again(bridge, tracker):
    await tracker.measure_point(duration_s=1.0)
    bridge.says |= {"measure_point": POINT | {"sequence": 3}, "initialise": READY | {"sequence": 3}}
    with pytest.raises(RemoteProtocolError, match="repeats itself"):
        await tracker.measure_point(duration_s=1.0)

    await tracker.connect()
    await tracker.initialise()

    with pytest.raises(RemoteProtocolError, match="measurement 3 after 3"):
        await tracker.measure_point(duration_s=1.0)


async def test_another_instrument_is_measured_with_after_initialising_only(bridge, tracker):
    bridge.says["measure_point"] = POINT | {"serial": "777"}

    for _ in range(2):
        with pytest.raises(NotInitialisedError, match="initialise it"):
            await tracker.measure_point(duration_s=1.0)

    bridge.says["initialise"] = READY | {"serial": "777"}
    await tracker.initialise()
    assert (await tracker.measure_point(duration_s=1.0)).samples == 1


@pytest.mark.parametrize(
    "use",
    [
        lambda tracker: tracker.measure_point(duration_s=1.0),
        lambda tracker: tracker.measure_pose(duration_s=1.0),
        lambda tracker: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0),
        lambda tracker: tracker.change_face(),
        lambda tracker: tracker.environment(),
    ],
)
async def test_nothing_is_measured_before_initialising(use):
    bridge = FakeBridge()
    tracker = tracker_on(bridge)
    await tracker.connect()

    with pytest.raises(NotInitialisedError, match="initialise it"):
        await use(tracker)

    assert [question["ask"] for question in bridge.asked] == ["hello"]


@pytest.mark.parametrize(
    "hello", [HELLO | {"version": 2}, HELLO | {"model": ""}, b"SSH-2.0\n", {"serial": "1"}]
)
async def test_whoever_speaks_another_language_is_told_in_connect(hello):
    tracker = tracker_on(FakeBridge(hello=hello))

    with pytest.raises(RemoteProtocolError):
        await tracker.connect()
    assert not tracker.connected


@pytest.mark.parametrize(
    "use",
    [
        lambda tracker: tracker.measure_point(duration_s=0.0),
        lambda tracker: tracker.measure_pose(duration_s=math.nan),
        lambda tracker: tracker.find_reflector((math.nan, 0.0, 0.0), search_radius_mm=1.0),
        lambda tracker: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=0.0),
    ],
)
async def test_an_absurd_question_is_never_asked(use):
    bridge = FakeBridge()
    tracker = await ready(bridge)

    with pytest.raises(ConfigurationError):
        await use(tracker)

    assert len(bridge.asked) == 2


@pytest.mark.parametrize(
    "said",
    [
        [b"".join(json.dumps({"id": 3, **POINT, "sequence": count}).encode() + b"\n" for count in (11, 12))],
        [b'{"id": 2, "serial": "12345"}\n', POINT],  # the answer to the question before
        [b"nonsense\n"],
        [b'{"id": 3, "busy": 1}\n'],
        [b"x" * 2000],
        [b'{"id": 3, "id": 3}\n'],
    ],
)
async def test_whatever_else_is_said_closes_the_link(said):
    tracker = await ready(FakeBridge(measure_point=said))

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected
