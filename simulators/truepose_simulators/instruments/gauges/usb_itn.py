"""The ballbar as a Digimatic gauge on a Mitutoyo USB-ITN cable: a keyboard, until it is told otherwise."""

import asyncio
import math

from truepose_drivers.line_gauges.protocol import NOT_CONNECTED, NOT_CONVERTIBLE, Value
from truepose_drivers.mitutoyo_usb_itn import protocol
from truepose_drivers.usb import protocol as usb
from truepose_simulators.faults.kinds import BallbarInches, BallbarKeyPressed, LineDoublesDigits
from truepose_simulators.instruments.endpoint import with_doubled_digit
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.usbip import StallError, StandardRequests

_SERIAL = "70012345"  # of the cable; it knows nothing of the gauge behind it
_INFO = "USB-ITN V1.00"
_BOOT_INTERFACE, _KEYBOARD = 1, 1
_DECIMALS, _DECIMALS_OF_INCHES = 4, 5
_MM_PER_INCH = 25.4
_UNKNOWN_COMMAND = 913  # no source tells what the cable answers to a command that it does not know
_NO_KEY = bytes(protocol.PACKET_BYTES)
_BOOT_PROTOCOL, _REPORT_PROTOCOL = 0, 1

# HID 1.11, appendix B.1: the boot keyboard's own report descriptor.
_KEYBOARD_REPORT = bytes.fromhex(
    "05010906a101050719e029e71500250175019508810295017508810195057501050819012905910295017503910195067508"
    "150025650507190029658100c0"
)


class UsbItnGadget:
    """State of the cable: its mode, and what it still has to send."""

    def __init__(self, bar: Electronics) -> None:
        self._bar = bar
        self._serial_mode = False
        self._pressed = False  # the DATA button, before the last question
        self._protocol = _REPORT_PROTOCOL
        self._outbox = bytearray()
        self._something_to_send = asyncio.Event()
        self.device = usb.Device(protocol.VENDOR, protocol.PRODUCT, release=0x0100, packet_bytes=8)
        endpoint = usb.Endpoint(0x81, usb.INTERRUPT, protocol.PACKET_BYTES, interval=10)
        interface = usb.Interface(
            0,
            usb.HID_CLASS,
            _BOOT_INTERFACE,
            _KEYBOARD,
            (endpoint,),
            report_descriptor_bytes=len(_KEYBOARD_REPORT),
        )
        self.configuration = usb.Configuration(1, (interface,))
        self._standard = StandardRequests(self.device, self.configuration, self._strings, _KEYBOARD_REPORT)

    @property
    def plugged(self) -> bool:
        """Whether it is plugged in."""
        return self._bar.plugged

    def attach(self) -> None:
        """Begin anew, as a keyboard."""
        self._standard.reset(self._strings)
        self._serial_mode = False
        self._protocol = _REPORT_PROTOCOL
        self._outbox.clear()
        self._something_to_send.clear()

    def control(self, setup: usb.Setup, data: bytes) -> bytes:
        """Answer a control transfer; raises StallError."""
        match setup.request_type, setup.request:
            case (int(kind), int(request)) if kind == usb.VENDOR_TO_DEVICE:
                self._vendor(request, setup.value, data)
                return b""
            case (int(kind), int(request)) if kind == usb.VENDOR_FROM_DEVICE and request == protocol.GET_MODE:
                return bytes([self._serial_mode])[: setup.length]
            case (int(kind), int(request)) if kind in (usb.CLASS_TO_INTERFACE, usb.CLASS_FROM_INTERFACE):
                return self._keyboard(request, setup)
        return self._standard.answer(setup)

    @property
    def _strings(self) -> tuple[str, str, str]:
        return "Mitutoyo", "USB-ITN", self._bar.serial(_SERIAL)

    async def ready(self) -> None:
        """Return when there is something to send; a keyboard on which nobody types has nothing."""
        await self._something_to_send.wait()

    def take_packet(self) -> bytes:
        """Return the next eight characters, or what is left."""
        packet = bytes(self._outbox[: protocol.PACKET_BYTES])
        del self._outbox[: protocol.PACKET_BYTES]
        if not self._outbox:
            self._something_to_send.clear()
        return packet

    def _vendor(self, request: int, value: int, data: bytes) -> None:
        if request == protocol.SET_MODE:
            self._serial_mode = value == protocol.SERIAL_MODE
        elif request == protocol.SEND_COMMAND and self._serial_mode:
            self._pressed = self._bar.has(BallbarKeyPressed) and not self._pressed
            if self._pressed:  # before every second question
                self._outbox += protocol.encode(self._reply(protocol.READ_VALUE))
            said = protocol.encode(self._reply(data))
            self._outbox += with_doubled_digit(said) if self._bar.has(LineDoublesDigits) else said
            self._something_to_send.set()
        else:
            raise StallError

    def _keyboard(self, request: int, setup: usb.Setup) -> bytes:
        match request:
            case usb.HidRequest.GET_REPORT:
                return _NO_KEY[: setup.length]
            case usb.HidRequest.GET_PROTOCOL:
                return bytes([self._protocol])
            case usb.HidRequest.SET_PROTOCOL if setup.value in (_BOOT_PROTOCOL, _REPORT_PROTOCOL):
                self._protocol = setup.value
                return b""
            case usb.HidRequest.GET_IDLE:
                return bytes(1)
            case usb.HidRequest.SET_IDLE | usb.HidRequest.SET_REPORT:  # the lamps of a keyboard
                return b""
        raise StallError

    def _reply(self, command: bytes) -> protocol.Reply:
        if command == protocol.READ_DEVICE:
            return protocol.DeviceInfo(_INFO)
        if command != protocol.READ_VALUE:
            return protocol.Error(_UNKNOWN_COMMAND)
        sample = self._bar.show()
        if sample.too_fast:
            return protocol.Error(NOT_CONVERTIBLE)
        if sample.signal == "none" or math.isnan(sample.deviation_mm):
            return protocol.Error(NOT_CONNECTED)
        if self._bar.has(BallbarInches):
            return Value(sample.deviation_mm / _MM_PER_INCH, _DECIMALS_OF_INCHES)
        return Value(sample.deviation_mm, _DECIMALS)
