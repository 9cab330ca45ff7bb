"""The camera's conversation, against a scripted camera that lives in memory."""

import asyncio
import math
from dataclasses import dataclass, field, replace

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.contract.wire import LoopClock
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    ConfigurationError,
    ConnectionLostError,
    DeviceRefusedError,
    LinkError,
    NotInitialisedError,
    OutOfVolumeError,
    RemoteProtocolError,
)
from truepose_drivers.ndi_polaris.driver import PLUGIN, PolarisTracker
from truepose_drivers.ndi_polaris.protocol import (
    OKAY,
    RESET,
    PortStatus,
    Request,
    RequestReader,
    Text,
    ToolFrame,
    ToolPose,
    encode_binary,
    encode_handles,
    encode_reply,
    encode_text,
    error_text,
)

pytestmark = pytest.mark.simulated_time

RATE_HZ = 60.0
VERSION = "Polaris Vega Control Firmware\nNDI S/N: P9-00123\nFreeze Tag: Polaris Vega Rev 002.001\n"
POSE = ToolPose((0.5, -0.5, 0.5, 0.5), (100.0, -200.0, -2000.0), 0.25)  # all of it exact in single floats
GOOD = PortStatus(0x31)


@dataclass
class FakeCamera:
    """Counts frames by the loop's time; `see` makes of each what the artefact shows."""

    says: dict[str, object] = field(default_factory=dict)  # command -> reply, None for silence
    see: object = staticmethod(lambda frame: ToolFrame(1, POSE, GOOD, frame))
    stands_at: int | None = None
    asked: list[Request] = field(default_factory=list)
    before: bytes = b""  # sent ahead of every answer
    after: bytes = b""
    pause_s: float = 0.0  # in the middle of every answer

    async def serve(self, end: MemoryEnd) -> None:
        reader = RequestReader()
        while data := await end.receive():
            reader.receive_data(data)
            while (request := reader.next_message()) is not None:
                assert isinstance(request, Request)
                self.asked.append(request)
                reply = self.says.get(request.name, self._usual)
                reply = reply(request) if callable(reply) else reply
                if reply is not None:
                    await self._send(end, reply if isinstance(reply, bytes) else encode_reply(reply))

    async def _send(self, end: MemoryEnd, data: bytes) -> None:
        data = self.before + data + self.after
        if self.pause_s:
            await end.send(data[:3])
            await asyncio.sleep(self.pause_s)
            data = data[3:]
        await end.send(data)

    def frame(self) -> int:
        if self.stands_at is not None:
            return self.stands_at
        return 1 + int(RATE_HZ * asyncio.get_running_loop().time())

    def _usual(self, request: Request):
        match request.name:
            case "PHSR":
                return encode_handles([(0x0B, 0x1)])
            case "PHRQ":
                return Text("01")
            case "VER":
                return Text(VERSION)
            case "APIREV":
                return Text("G.003.006")
            case "GETINFO":
                return Text("Features.Hardware.Model=Polaris Vega VT\n")
            case "BX":
                return encode_binary([self.see(self.frame())])
            case "TX":
                return encode_text([self.see(self.frame())])
        return OKAY

    def driver(self, chunk_bytes: int = 65_536) -> PolarisTracker:
        link = MemoryLink(self.serve, chunk_bytes=chunk_bytes)
        return PolarisTracker(link, LoopClock(), b"NDI" + bytes(749))

    async def ready(self, chunk_bytes: int = 65_536) -> PolarisTracker:
        driver = self.driver(chunk_bytes)
        await driver.connect()
        await driver.initialise()
        return driver


@pytest.fixture
def camera():
    return FakeCamera()


@pytest.fixture
async def driver(camera):
    driver = await camera.ready()
    yield driver
    await driver.close()


@pytest.mark.parametrize("chunk_bytes", [1, 7, 65_536])
async def test_a_pose_is_the_mean_of_the_frames_of_its_time_however_they_are_cut(chunk_bytes):
    def shaken(frame):
        x = 100.0 + 0.5 * (-1) ** frame
        return ToolFrame(1, replace(POSE, position_mm=(x, -200.0, -2000.0)), GOOD, frame)

    driver = await FakeCamera(see=shaken).ready(chunk_bytes)

    reading = await driver.measure_pose(duration_s=1.0)

    assert reading.frames == pytest.approx(RATE_HZ, abs=1)
    assert reading.quaternion == POSE.quaternion
    assert reading.position_mm == pytest.approx((100.0, -200.0, -2000.0), abs=0.5 / 59)  # one odd frame
    assert reading.position_deviation_mm == pytest.approx((0.5, 0.0, 0.0), rel=0.02)
    assert reading.rotation_deviation_rad == 0.0
    assert reading.rms_mm == 0.25
    assert reading.duration_s == 1.0
    assert reading.time_s == pytest.approx(asyncio.get_running_loop().time())
    await driver.close()


async def test_the_definition_is_loaded_into_a_free_handle_after_what_others_left_was_freed():
    camera = FakeCamera(says={"TSTOP": error_text(0x0C)})  # it was not tracking
    driver = await camera.ready()

    names = [request.name for request in camera.asked if request.name != "VER"]
    written = "".join(request.arguments[6:] for request in camera.asked if request.name == "PVWR")
    assert names[:5] == ["TSTOP", "INIT", "PHSR", "PHF", "PHRQ"]
    assert names[5:-1] == ["PVWR"] * 16 + ["PINIT", "PENA", "TSTART"]
    assert Request("PHF", "0B") in camera.asked
    assert Request("PENA", "01D") in camera.asked
    assert bytes.fromhex(written) == b"NDI" + bytes(1021)
    await driver.close()


async def test_a_camera_says_who_it_is(driver):
    who = await driver.identify()

    assert (who.manufacturer, who.model, who.serial) == ("Northern Digital", "Polaris Vega VT", "P9-00123")
    assert who.firmware == "002.001 API G.003.006"


async def test_an_older_camera_knows_fewer_questions_and_no_binary_frames():
    unknown = error_text(0x01)
    camera = FakeCamera(says={"GETINFO": unknown, "APIREV": unknown, "BX": unknown})
    driver = await camera.ready()

    who = await driver.identify()
    reading = await driver.measure_pose(duration_s=0.1)

    assert (who.model, who.serial, who.firmware) == ("Polaris Vega", "P9-00123", "002.001")
    assert reading.position_mm == pytest.approx(POSE.position_mm, abs=0.005)
    await driver.close()


async def test_a_frame_from_before_the_measurement_does_not_count(camera, driver):
    still_moving, before = replace(POSE, position_mm=(0.0, 0.0, -1500.0)), camera.frame()
    camera.see = lambda frame: ToolFrame(1, POSE if frame > before else still_moving, GOOD, frame)

    reading = await driver.measure_pose(duration_s=0.1)

    assert reading.position_mm == POSE.position_mm
    assert reading.position_deviation_mm == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("back", [0, 5])
async def test_frames_that_do_not_go_on_are_a_lost_camera(camera, driver, back):
    await driver.measure_pose(duration_s=0.2)
    camera.stands_at = camera.frame() - back

    began_s = asyncio.get_running_loop().time()
    with pytest.raises(LinkError, match="do not advance"):
        await driver.measure_pose(duration_s=10.0)

    assert asyncio.get_running_loop().time() - began_s < 1.0
    assert not driver.connected


@pytest.mark.parametrize(
    ("pose", "status", "error", "said"),
    [
        (None, GOOD, ArtefactNotSeenError, r"did not see the artefact in (\d+) of \1 frames.*clear its view"),
        (
            POSE,
            GOOD | PortStatus.OUT_OF_VOLUME,
            OutOfVolumeError,
            "was outside the camera's measuring volume",
        ),
        (None, GOOD | PortStatus.OUT_OF_VOLUME, OutOfVolumeError, "was outside"),
        (POSE, GOOD | PortStatus.PARTIALLY_OUT_OF_VOLUME, OutOfVolumeError, "was partly outside"),
    ],
)
async def test_an_artefact_that_is_not_measured_is_no_pose(camera, driver, pose, status, error, said):
    camera.see = lambda frame: ToolFrame(1, pose, status, frame)

    with pytest.raises(error, match=said):
        await driver.measure_pose(duration_s=0.2)

    assert driver.connected
    camera.see = lambda frame: ToolFrame(1, POSE, GOOD, frame)
    assert (await driver.measure_pose(duration_s=0.2)).position_mm == POSE.position_mm


@pytest.mark.parametrize(("of_hundred", "is_pose"), [(5, True), (50, False)])
async def test_a_few_lost_frames_spoil_no_measurement(camera, driver, of_hundred, is_pose):
    camera.see = lambda frame: ToolFrame(1, None if frame % 100 < of_hundred else POSE, GOOD, frame)

    if is_pose:
        assert (await driver.measure_pose(duration_s=5.0)).frames == pytest.approx(285, abs=3)
    else:
        with pytest.raises(ArtefactNotSeenError):
            await driver.measure_pose(duration_s=5.0)


async def test_a_camera_that_was_switched_off_and_on_must_be_connected_again(camera, driver):
    camera.says["BX"] = RESET

    with pytest.raises(ConnectionLostError, match="started again"):
        await driver.measure_pose(duration_s=0.2)
    assert not driver.connected
    del camera.says["BX"]
    await driver.connect()
    with pytest.raises(NotInitialisedError):
        await driver.measure_pose(duration_s=0.2)
    await driver.initialise()

    assert (await driver.measure_pose(duration_s=0.2)).position_mm == POSE.position_mm


@pytest.mark.parametrize("tool", [ToolFrame(2, POSE, GOOD, 10**6), ToolFrame(1, None, disabled=True)])
async def test_another_artefact_is_not_ours(camera, driver, tool):
    camera.see = lambda frame: tool

    with pytest.raises(NotInitialisedError, match="no longer tracks the artefact"):
        await driver.measure_pose(duration_s=0.2)
    del camera.see

    with pytest.raises(NotInitialisedError, match="not been initialised since"):
        await driver.measure_pose(duration_s=0.2)


@pytest.mark.parametrize(
    ("code", "error"),
    [
        (0x0C, NotInitialisedError),
        (0x39, DeviceRefusedError),
        (0x77, DeviceRefusedError),
        (0x04, RemoteProtocolError),
    ],
)
async def test_a_refusal_is_told_by_its_number(camera, driver, code, error):
    camera.says["BX"] = error_text(code)

    with pytest.raises(error, match=f"refused BX .error {code:02X}."):
        await driver.measure_pose(duration_s=0.2)

    assert driver.connected == (code != 0x04)


async def test_nothing_is_measured_in_no_time_or_before_initialising():
    driver = FakeCamera().driver()
    with pytest.raises(NotInitialisedError, match="not been initialised since it was connected"):
        await driver.measure_pose(duration_s=1.0)
    await driver.connect()
    await driver.initialise()

    for duration_s in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ConfigurationError, match="positive time"):
            await driver.measure_pose(duration_s=duration_s)
    await driver.close()


def test_the_definition_comes_from_a_file(tmp_path):
    good, large, empty = (tmp_path / name for name in ("good.rom", "large.rom", "empty.rom"))
    good.write_bytes(bytes(752))
    large.write_bytes(bytes(1025))
    empty.write_bytes(b"")
    address = {"host": "192.168.0.5"}

    assert isinstance(PLUGIN.open({**address, "tool_file": str(good)}, None), PolarisTracker)
    for options in (
        address,
        *({**address, "tool_file": str(path)} for path in (large, empty, tmp_path / "no.rom")),
    ):
        with pytest.raises(ConfigurationError, match="option tool_file"):
            PLUGIN.open(options, None)
