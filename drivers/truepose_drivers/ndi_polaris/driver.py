"""An optical tracker that states poses of an artefact, over NDI's combined API."""

import asyncio
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final, Literal, TypeVar

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options, PoseReading
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    ConfigurationError,
    DeviceRefusedError,
    MeasurementFailedError,
    NoReplyError,
    NotInitialisedError,
    OutOfVolumeError,
)
from truepose_drivers.ndi_polaris import protocol
from truepose_drivers.ndi_polaris.error_codes import CommandUnknownError, refusal, started_again
from truepose_drivers.ndi_polaris.mean import mean_pose
from truepose_drivers.ndi_polaris.serial_line import FIRST_BAUD, CameraLine
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OnePortDevice, introduction, now_s
from truepose_drivers.transports.serial import Framing, SerialLink
from truepose_drivers.transports.tcp import tcp_link

_MANUFACTURER = "Northern Digital"
_REPLY_TIMEOUT_S: Final = 5.0  # what public clients allow
_START_UP_TIMEOUT_S: Final = 15.0
_FRAME_TIMEOUT_S: Final = (
    1.5  # a frame comes within 50 ms; a camera that is gone is to be known in two seconds
)
_STANDING_S: Final = 0.5  # thirty frames of the slowest model; one that counts none meanwhile hangs
_POLL_S: Final = 0.002  # between two looks at the same frame
_SEEN_SHARE: Final = 0.9  # of the frames; below it what is left says little of where the artefact was
_FRAMES = "0801"  # poses, those outside the measuring volume too, which their status then tells
_ALL_HANDLES = protocol.Request("PHSR", "00")
_VERSION = protocol.Request("VER", "0")  # which every model knows
_HARDWARE = protocol.Request("GETINFO", "Features.Hardware.*")

_Lost = Literal["missing", "outside", "partly"]
Value = TypeVar("Value")


class PolarisTracker(OnePortDevice):
    """A Polaris or Vega on a link. Keeps the conversation; computes a mean and nothing else.

    `definition` are the bytes of the artefact's tool definition (.rom).
    """

    def __init__(self, link: Link, clock: Clock, definition: bytes) -> None:
        self._conversation: Conversation[protocol.Reply] = Conversation(
            link, protocol.ReplyReader, harmless=(DeviceRefusedError, MeasurementFailedError)
        )
        super().__init__(self._conversation)
        self._clock = clock
        self._definition = definition
        self._handle: int | None = None  # of the artefact; None before the camera was initialised
        self._frame = 0  # counted last
        self._speaks_binary = True

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError. To be initialised afterwards."""
        self._handle = None
        await self._conversation.open()
        async with introduction(self._conversation):
            await self._text(_VERSION)

    async def identify(self) -> DeviceIdentity:
        """Ask for model, serial number and firmware; older models know VER alone."""
        who = protocol.identity_of(protocol.facts(await self._text(_VERSION)), await self._hardware())
        firmware = " ".join(filter(None, (who.firmware, await self._interface())))
        return DeviceIdentity(
            _MANUFACTURER, who.model or "unknown", who.serial or "unknown", firmware or "unknown"
        )

    async def initialise(self) -> None:
        """Free what other programs left, load the artefact's definition, begin to track.

        Raises DeviceRefusedError where the camera cannot, or cannot use the definition.
        """
        self._handle = None
        # What state the program before left the camera in nobody knows: each step here undoes one such state.
        await self._stop()
        await self._okay(protocol.Request("INIT"), timeout_s=_START_UP_TIMEOUT_S)
        # What other programs left takes up places, of which a camera has few (errors 28 and 2D).
        for handle, _ in protocol.decode_handles(await self._text(_ALL_HANDLES)):
            await self._okay(protocol.Request("PHF", f"{handle:02X}"))
        handle = protocol.decode_handle(await self._text(protocol.ANY_PASSIVE_TOOL))
        for write in protocol.page_writes(handle, self._definition):
            await self._okay(write)
        await self._okay(protocol.Request("PINIT", f"{handle:02X}"))
        await self._okay(protocol.Request("PENA", f"{handle:02X}D"))
        # 80 begins the count of frames again: whatever comes from now on is newer than frame 0.
        await self._okay(protocol.Request("TSTART", "80"), timeout_s=_START_UP_TIMEOUT_S)
        self._frame = 0
        await self._choose_form(handle)
        self._handle = handle

    async def measure_pose(self, *, duration_s: float) -> PoseReading:
        """Take the mean of the frames of `duration_s`; raises ArtefactNotSeenError, OutOfVolumeError."""
        handle = self._required_handle()
        if not (math.isfinite(duration_s) and duration_s > 0.0):
            raise ConfigurationError(f"a measurement of {duration_s} s is none: give a positive time")
        await self._next_frame(handle)  # may have been taken before we were asked
        poses, lost = await self._frames(handle, duration_s)
        _require_seen(len(poses), lost)
        mean = mean_pose(poses)
        return PoseReading(
            quaternion=mean.quaternion,
            position_mm=mean.position_mm,
            position_deviation_mm=mean.deviation_mm,
            rotation_deviation_rad=mean.deviation_rad,
            rms_mm=mean.error_mm,
            frames=len(poses),
            duration_s=duration_s,
            time_s=await self._clock.now_s(),
        )

    async def _frames(self, handle: int, duration_s: float) -> tuple[list[protocol.ToolPose], Counter[_Lost]]:
        """Return the poses of the time to come, and how often there was none for which reason."""
        poses: list[protocol.ToolPose] = []
        lost: Counter[_Lost] = Counter()
        end_s = await self._clock.now_s() + duration_s
        while not (poses or lost) or await self._clock.now_s() < end_s:
            seen = _seen(await self._next_frame(handle))
            if isinstance(seen, protocol.ToolPose):
                poses.append(seen)
            else:
                lost[seen] += 1
        return poses, lost

    async def _next_frame(self, handle: int) -> protocol.ToolFrame:
        """Return the artefact in the next frame; raises NoReplyError where the frames stand still."""
        # Wall time: the question is whether the camera hangs. How long is measured goes by the cell's clock.
        give_up_s = now_s() + _STANDING_S
        while True:
            tool = await self._tool(handle)
            if tool.frame > self._frame:
                self._frame = tool.frame
                return tool
            if tool.frame < self._frame or now_s() >= give_up_s:
                await self.close()
                raise NoReplyError(
                    f"the frames of the camera do not advance (frame {tool.frame} after {self._frame}), so"
                    " its data is old: check that it is still running, then connect again"
                )
            await asyncio.sleep(_POLL_S)

    async def _tool(self, handle: int) -> protocol.ToolFrame:
        """Return the artefact as the camera states it now."""
        tools = await self._tracked()
        ours = [tool for tool in tools if tool.handle == handle]
        if len(ours) != 1 or ours[0].disabled:
            self._handle = None
            raise NotInitialisedError(
                "the camera no longer tracks the artefact: close every other program that is"
                " connected to it, then initialise it"
            )
        return ours[0]

    async def _tracked(self) -> list[protocol.ToolFrame]:
        name, decode = ("BX", _binary_tools) if self._speaks_binary else ("TX", _text_tools)
        return await self._ask(protocol.Request(name, _FRAMES), decode, timeout_s=_FRAME_TIMEOUT_S)

    async def _choose_form(self, handle: int) -> None:
        """Speak binary where the camera does; text has a hundredth of a millimetre only."""
        self._speaks_binary = True
        try:
            await self._tool(handle)
        except CommandUnknownError:
            self._speaks_binary = False
            await self._tool(handle)

    async def _stop(self) -> None:
        """Leave the tracking of whoever was here before; a camera that was not tracking refuses."""
        try:
            await self._okay(protocol.Request("TSTOP"))
        except DeviceRefusedError:
            return

    async def _hardware(self) -> dict[str, str]:
        try:
            return protocol.facts(await self._text(_HARDWARE))
        except DeviceRefusedError:
            return {}

    async def _interface(self) -> str:
        try:
            return f"API {(await self._text(protocol.Request('APIREV'))).text.strip()}"
        except DeviceRefusedError:
            return ""

    def _required_handle(self) -> int:
        if self._handle is None:
            raise NotInitialisedError(
                "the camera has not been initialised since it was connected: initialise it first"
            )
        return self._handle

    async def _okay(self, request: protocol.Request, *, timeout_s: float = _REPLY_TIMEOUT_S) -> None:
        await self._ask(request, _okayed, timeout_s=timeout_s)

    async def _text(self, request: protocol.Request) -> protocol.Text:
        return await self._ask(request, _text)

    async def _ask(
        self,
        request: protocol.Request,
        decode: Callable[[protocol.Reply], Value],
        *,
        timeout_s: float = _REPLY_TIMEOUT_S,
    ) -> Value:
        def answered(reply: protocol.Reply) -> Value:
            if reply == protocol.RESET:
                raise started_again()
            code = protocol.error_code(reply)
            if code is not None:
                raise refusal(request.name, code)
            return decode(reply)

        silence = (
            f"the camera at {self._conversation.address} did not answer {request.name} in time:"
            " check that it is still running, then connect again"
        )
        return await self._conversation.ask(
            protocol.encode_request(request),
            answered,
            timeout_s=timeout_s,
            silence=silence,
        )


def _text(reply: protocol.Reply) -> protocol.Text:
    if not isinstance(reply, protocol.Text):
        raise protocol.NdiProtocolError("the camera sent a frame without a request: connect again")
    return reply


def _binary_tools(reply: protocol.Reply) -> list[protocol.ToolFrame]:
    return protocol.decode_binary(_binary(reply))


def _text_tools(reply: protocol.Reply) -> list[protocol.ToolFrame]:
    return protocol.decode_text(_text(reply))


def _okayed(reply: protocol.Reply) -> None:
    if reply != protocol.OKAY:
        raise protocol.NdiProtocolError(
            f"the camera answered {_text(reply).text[:40]!r} instead of an acknowledgement"
        )


def _binary(reply: protocol.Reply) -> protocol.Binary:
    if not isinstance(reply, protocol.Binary):
        raise protocol.NdiProtocolError(f"the camera answered {reply.text[:40]!r} instead of a frame")
    return reply


def _seen(tool: protocol.ToolFrame) -> protocol.ToolPose | _Lost:
    """Return the pose of a frame, or why there is none to be trusted."""
    # Before the pose: in mode 0801 the camera states poses outside its volume too, and they are never used.
    if tool.status & protocol.PortStatus.OUT_OF_VOLUME:
        return "outside"
    if tool.pose is None:
        return "missing"
    return "partly" if tool.status & protocol.PortStatus.PARTIALLY_OUT_OF_VOLUME else tool.pose


def _require_seen(seen: int, lost: Counter[_Lost]) -> None:
    """Raise where too few frames show the artefact; names what most of the others say."""
    frames = seen + lost.total()
    if seen >= _SEEN_SHARE * frames:
        return
    reason, _ = lost.most_common(1)[0]
    share = f"in {lost.total()} of {frames} frames"
    if reason == "missing":
        raise ArtefactNotSeenError(
            f"the camera did not see the artefact {share}: clear its view, turn the artefact towards it,"
            " then repeat the configuration"
        )
    where = "outside" if reason == "outside" else "partly outside"
    raise OutOfVolumeError(
        f"the artefact was {where} the camera's measuring volume {share}: choose another configuration,"
        " or reposition the camera"
    )


def _open(options: Options, clock: Clock) -> PolarisTracker:
    return PolarisTracker(_link(options), clock, _definition(options))


def _link(options: Options) -> Link:
    port = option.text(options, "serial")
    if port is None:
        return tcp_link(options, protocol.DEFAULT_PORT)
    return CameraLine(SerialLink(port, Framing(FIRST_BAUD)))


def _definition(options: Options) -> bytes:
    name = option.text(options, "tool_file")
    if name is None:
        raise ConfigurationError(
            "option tool_file is missing: name the artefact's tool definition, a .rom file"
        )
    try:
        with Path(name).open("rb") as file:
            definition = file.read(protocol.LARGEST_DEFINITION + 1)
    except OSError as error:
        raise ConfigurationError(f"option tool_file: {name} cannot be read ({error.strerror})") from error
    if not 0 < len(definition) <= protocol.LARGEST_DEFINITION:
        raise ConfigurationError(
            f"option tool_file: {name} is not a tool definition, which has 1 to"
            f" {protocol.LARGEST_DEFINITION} bytes"
        )
    return definition


_OPTIONS = {
    "host": "address of the camera, by its label or the manufacturer's tool",
    "serial": "serial port instead, of a camera without Ethernet",
    "port": f"TCP port, default {protocol.DEFAULT_PORT}",
    "tool_file": "file with the artefact's tool definition (.rom)",
}
PLUGIN = DriverPlugin("ndi_polaris", "pose_tracker", "ndi", _OPTIONS, _open)
