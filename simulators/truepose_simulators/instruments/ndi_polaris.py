"""NDI's combined API in front of the simulated camera: port handles, tool definitions, tracking.

Whatever a definition says, an enabled tool is the artefact on the flange. A frame that a client has seen is
not sent to it again: the next one is waited for.
"""

import asyncio
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.ndi_polaris import protocol
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import CameraFrozen
from truepose_simulators.instruments.accuracy import CameraSetup
from truepose_simulators.instruments.camera import Camera
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096
_MODEL, _FIRMWARE, _INTERFACE = "Polaris Vega VT", "002.001.000", "G.003.006"
_INVALID_COMMAND, _TOO_LONG, _BAD_CRC, _WRONG_PARAMETERS, _BAD_HANDLE = 0x01, 0x02, 0x04, 0x07, 0x08
_WRONG_MODE, _NOT_INITIALISED_TOOL, _NOT_INITIALISED, _NO_HANDLE, _NO_PARAMETER = 0x0C, 0x0E, 0x10, 0x2D, 0x34
_HEX = re.compile(r"[0-9A-Fa-f]{1,8}")
_MOST_HANDLES = 15
_OUTSIDE_TOO = 0x0800  # reply option: poses outside of the measuring volume are told
_SETUP_ONLY = frozenset({"PHRQ", "PVWR", "PINIT", "PENA", "PDIS", "PHF", "TSTART"})
_FIRST_SERIAL = 10_000
_SEEDS = 10_000
_JUST_AFTER_S = 1e-6  # a frame's own time is rounded


class _RefusedError(Exception):
    """The camera refuses, with the number of an error."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


@dataclass
class _Port:
    """A port handle and the tool in it."""

    definition: bytearray = field(default_factory=lambda: bytearray(protocol.LARGEST_DEFINITION))
    loaded: bool = False
    status: protocol.PortStatus = protocol.PortStatus.TOOL_IN_PORT


@dataclass
class _Client:
    """One connection."""

    frame: int = -1  # sent last


class Polaris:
    """State of the camera, which outlives connections, and its answers."""

    def __init__(self, cell: Cell, setup: CameraSetup) -> None:
        self._cell = cell
        self._camera = Camera(cell, setup)
        self._initialised = False
        self._tracking = False
        self._zero_s = 0.0  # cell time of frame 0
        self._ports: dict[int, _Port] = {}
        self._answers: Mapping[str, Callable[[str], protocol.Reply]] = {
            "INIT": self._initialise,
            "COMM": lambda _: protocol.OKAY,
            "VER": self._version,
            "APIREV": lambda _: protocol.Text(_INTERFACE),
            "GET": self._info,
            "GETINFO": self._info,
            "PHSR": self._handles,
            "PHRQ": self._request_handle,
            "PVWR": self._write,
            "PINIT": self._initialise_tool,
            "PENA": self._enable,
            "PDIS": self._disable,
            "PHF": self._free,
            "PHINF": self._tool,
            "TSTART": self._start,
            "TSTOP": self._stop,
        }

    @property
    def camera(self) -> Camera:
        """The device behind the protocol."""
        return self._camera

    async def answer(
        self, asked: protocol.Request | protocol.DamagedRequest, client: _Client
    ) -> protocol.Reply:
        """Return the reply to a request."""
        try:
            if isinstance(asked, protocol.DamagedRequest):
                raise _RefusedError(
                    _TOO_LONG if asked.too_long else _BAD_CRC if asked.checksum else _INVALID_COMMAND
                )
            if asked.name in ("TX", "BX"):
                return await self._track(asked, client)
            if asked.name not in self._answers:
                raise _RefusedError(_INVALID_COMMAND)
            if self._tracking and asked.name in _SETUP_ONLY:
                raise _RefusedError(_WRONG_MODE)
            return self._answers[asked.name](asked.arguments)
        except _RefusedError as refused:
            return protocol.error_text(refused.code)

    async def _track(self, asked: protocol.Request, client: _Client) -> protocol.Reply:
        if not self._tracking:
            raise _RefusedError(_WRONG_MODE)
        options = _number(asked.arguments or "0001")
        if not self._cell.faults.holds(CameraFrozen, self._cell.clock.now_s):
            await self._next_frame(client)
        self._cell.measured_here()
        encode = protocol.encode_binary if asked.name == "BX" else protocol.encode_text
        outside_too = bool(options & _OUTSIDE_TOO)
        enabled = [
            handle for handle, port in self._ports.items() if protocol.PortStatus.ENABLED in port.status
        ]
        return encode([self._seen(handle, max(client.frame, 0), outside_too) for handle in enabled])

    async def _next_frame(self, client: _Client) -> None:
        """Wait until there is a frame that the client has not seen."""
        rate_hz = self._camera.setup.frame_hz
        if (frame := self._frame()) <= client.frame:
            due_s = self._zero_s + (client.frame + 1) / rate_hz + _JUST_AFTER_S
            await self._cell.clock.sleep(max(0.0, due_s - self._cell.clock.now_s))
            frame = max(self._frame(), client.frame + 1)
        client.frame = frame

    def _frame(self) -> int:
        return math.floor((self._cell.clock.now_s - self._zero_s) * self._camera.setup.frame_hz)

    def _seen(self, handle: int, frame: int, outside_too: bool) -> protocol.ToolFrame:
        status, seen = self._ports[handle].status, self._camera.see(frame)
        if seen is None:
            return protocol.ToolFrame(handle, None, status, frame)
        if seen.nests_outside == len(self._cell.scenario.tool.nests_mm):
            status |= protocol.PortStatus.OUT_OF_VOLUME
        elif seen.nests_outside:
            status |= protocol.PortStatus.PARTIALLY_OUT_OF_VOLUME
        if protocol.PortStatus.OUT_OF_VOLUME in status and not outside_too:
            return protocol.ToolFrame(handle, None, status, frame)
        q0, qx, qy, qz = map(float, seen.quaternion)
        x, y, z = map(float, seen.position_mm)
        return protocol.ToolFrame(
            handle, protocol.ToolPose((q0, qx, qy, qz), (x, y, z), seen.rms_mm), status, frame
        )

    def _initialise(self, _: str) -> protocol.Reply:
        """Begin anew; port handles stay until they are freed, which finds programs that do not free them."""
        self._initialised, self._tracking = True, False
        return protocol.OKAY

    def _version(self, _: str) -> protocol.Reply:
        lines = (
            "Polaris Vega Control Firmware",
            f"NDI S/N: {self._serial()}",
            f"Freeze Tag: Polaris Vega Rev {_FIRMWARE}",
        )
        return protocol.Text("\n".join(lines) + "\n")

    def _info(self, pattern: str) -> protocol.Reply:
        known = {
            "Features.Hardware.Model": _MODEL,
            "Features.Hardware.Serial Number": self._serial(),
            "Features.Firmware.Version": _FIRMWARE,
            "Param.Tracking.Frame Frequency": f"{self._camera.setup.frame_hz:g}",
        }
        begin = pattern.rstrip("*")
        found = [f"{name}={value}\n" for name, value in known.items() if name.startswith(begin)]
        if not found:
            raise _RefusedError(_NO_PARAMETER)
        return protocol.Text("".join(found))

    def _serial(self) -> str:
        own = f"P9-{_FIRST_SERIAL + self._cell.seed % _SEEDS}"
        return self._cell.faults.serial("pose_tracker", own, self._cell.clock.now_s)

    def _handles(self, which: str) -> protocol.Reply:
        self._require_initialised()
        chosen = _CHOSEN.get(which or "00")
        if chosen is None:
            raise _RefusedError(_WRONG_PARAMETERS)
        return protocol.encode_handles([
            (handle, port.status) for handle, port in self._ports.items() if chosen(port)
        ])

    def _request_handle(self, _: str) -> protocol.Reply:
        self._require_initialised()
        free = [handle for handle in range(1, _MOST_HANDLES + 1) if handle not in self._ports]
        if not free:
            raise _RefusedError(_NO_HANDLE)
        self._ports[free[0]] = _Port()
        return protocol.Text(f"{free[0]:02X}")

    def _write(self, arguments: str) -> protocol.Reply:
        port, address = self._port(arguments), _number(arguments[2:6])
        page = _bytes(arguments[6:])
        if len(page) != protocol.PAGE_BYTES or address + protocol.PAGE_BYTES > protocol.LARGEST_DEFINITION:
            raise _RefusedError(_WRONG_PARAMETERS)
        port.definition[address : address + protocol.PAGE_BYTES] = page
        port.loaded = True
        return protocol.OKAY

    def _initialise_tool(self, arguments: str) -> protocol.Reply:
        port = self._port(arguments)
        if not port.loaded:
            raise _RefusedError(_NOT_INITIALISED_TOOL)
        port.status |= protocol.PortStatus.INITIALISED
        return protocol.OKAY

    def _enable(self, arguments: str) -> protocol.Reply:
        port = self._port(arguments)
        if arguments[2:3] not in ("S", "D", "B"):
            raise _RefusedError(_WRONG_PARAMETERS)
        if protocol.PortStatus.INITIALISED not in port.status:
            raise _RefusedError(_NOT_INITIALISED_TOOL)
        port.status |= protocol.PortStatus.ENABLED
        return protocol.OKAY

    def _disable(self, arguments: str) -> protocol.Reply:
        self._port(arguments).status &= ~protocol.PortStatus.ENABLED
        return protocol.OKAY

    def _free(self, arguments: str) -> protocol.Reply:
        self._port(arguments)
        del self._ports[_number(arguments[:2])]
        return protocol.OKAY

    def _tool(self, arguments: str) -> protocol.Reply:
        """Tell what the bits of the reply option ask for, lowest first."""
        port, wanted = self._port(arguments), _number(arguments[2:] or "0001")
        if not wanted or wanted & ~sum(_TOLD):
            raise _RefusedError(_WRONG_PARAMETERS)
        about = f"{_number(arguments[:2]):02X}"
        return protocol.Text("".join(tell(about, port) for bit, tell in _TOLD.items() if wanted & bit))

    def _start(self, arguments: str) -> protocol.Reply:
        self._require_initialised()
        if arguments == "80":
            self._zero_s = self._cell.clock.now_s
        self._tracking = True
        return protocol.OKAY

    def _stop(self, _: str) -> protocol.Reply:
        if not self._tracking:
            raise _RefusedError(_WRONG_MODE)
        self._tracking = False
        return protocol.OKAY

    def _require_initialised(self) -> None:
        if not self._initialised:
            raise _RefusedError(_NOT_INITIALISED)

    def _port(self, arguments: str) -> _Port:
        self._require_initialised()
        port = self._ports.get(_number(arguments[:2]))
        if port is None:
            raise _RefusedError(_BAD_HANDLE)
        return port


_CHOSEN: Mapping[str, Callable[[_Port], bool]] = {
    "00": lambda port: True,
    "01": lambda port: False,  # to be freed: nobody takes a passive tool out of its port
    "02": lambda port: protocol.PortStatus.INITIALISED not in port.status,
    "03": lambda port: (
        protocol.PortStatus.INITIALISED in port.status and protocol.PortStatus.ENABLED not in port.status
    ),
    "04": lambda port: protocol.PortStatus.ENABLED in port.status,
}

# What PHINF tells by the bits of its reply option, of fixed lengths; the arguments are handle and port.
_TOLD: Mapping[int, Callable[[str, _Port], str]] = {
    # type 8, manufacturer 12, revision 3, serial number 8, status 2
    0x0001: lambda _, port: f"02000000{'truepose':12}00100000001{port.status & 0xFF:02X}",
    0x0004: lambda *_: f"{'artefact':20}",  # part number
    0x0008: lambda *_: "00",  # accessories: none
    0x0010: lambda *_: "00",  # marker type: not stated
    0x0020: lambda handle, _: f"{'':0<8}01{handle}00",  # hardware 8, system, wireless tool, port 2, channel 2
}


def _number(digits: str) -> int:
    if not _HEX.fullmatch(digits):
        raise _RefusedError(_WRONG_PARAMETERS)
    return int(digits, 16)


def _bytes(digits: str) -> bytes:
    try:
        return bytes.fromhex(digits)
    except ValueError:
        raise _RefusedError(_WRONG_PARAMETERS) from None


def camera_endpoint(cell: Cell, setup: CameraSetup) -> Endpoint:
    """Build the endpoint of the camera; every connection reaches the same one."""
    polaris = Polaris(cell, setup)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        requests, client = protocol.RequestReader(), _Client()
        while data := await reader.read(_CHUNK_BYTES):
            requests.receive_data(data)
            try:
                while (asked := requests.next_message()) is not None:
                    writer.write(protocol.encode_reply(await polaris.answer(asked, client)))
            except RemoteProtocolError:  # no end of a request in sight: nothing can be read any more
                return
            await writer.drain()

    return Endpoint("camera", "ndi", serve)
