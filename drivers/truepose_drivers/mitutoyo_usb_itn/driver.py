"""A Digimatic gauge on a Mitutoyo USB-ITN cable: on this computer, or over USB/IP."""

import math

from truepose_drivers import options as option
from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.line_gauges.conversation import decimals as decimals_option
from truepose_drivers.line_gauges.protocol import MOST_LESSONS, Value, ValueForm
from truepose_drivers.mitutoyo_usb_itn import protocol
from truepose_drivers.transports.conversation import Listener
from truepose_drivers.transports.link import OnePortDevice, introduction
from truepose_drivers.transports.usb import UsbDevice, UsbPort, usb_address
from truepose_drivers.usb.protocol import VENDOR_FROM_DEVICE, VENDOR_TO_DEVICE

_REPLY_TIMEOUT_S = 1.0  # a Digimatic gauge takes up to a quarter of a second to send its value
_ANY_CABLE = f"{protocol.VENDOR:04x}:{protocol.PRODUCT:04x}"
# A Digimatic gauge does not tell that it stands at its stop. Unless told otherwise it is taken for a
# ballbar's, which travels 1 mm either way.
_RANGE_MM = 1.0
_MOST_TRIES = 2  # of a question that somebody's press of a key disturbed
_PLUG = "unplug the cable and plug it in again"


class UsbItnGauge(OnePortDevice):
    """A gauge on a USB-ITN cable. It answers when asked, and sends when somebody presses its DATA button."""

    def __init__(
        self,
        port: UsbPort,
        clock: Clock,
        *,
        range_mm: float = _RANGE_MM,
        decimals: int | None = None,
        reply_timeout_s: float = _REPLY_TIMEOUT_S,
    ) -> None:
        """Prepare; `decimals` stand behind the point in millimetres, learnt from the values unless given."""
        super().__init__(port)
        self._port: UsbPort = port
        self._clock = clock
        self._range_mm = range_mm
        self._reply_timeout_s = reply_timeout_s
        self._form = ValueForm(decimals, protocol.ItnProtocolError)  # kept over connections, as the gauge is
        self._replies: Listener[protocol.Reply] = Listener(port, protocol.ReplyReader)

    async def connect(self) -> None:
        """Take the cable from the keyboard driver, make it talk and say who it is.

        Raises ConnectFailedError.
        """
        await self._replies.open()
        async with introduction(self._replies, "check that it is a USB-ITN cable"), self._replies.turn():
            # Set the mode, read it back, then ask: the order of the public clients. Mitutoyo publishes
            # nothing about it, so no step is left out.
            await self._port.control_out(VENDOR_TO_DEVICE, protocol.SET_MODE, protocol.SERIAL_MODE)
            await self._port.control_in(VENDOR_FROM_DEVICE, protocol.GET_MODE, 0, 0, 1)
            await self._ask_device()

    async def identify(self) -> DeviceIdentity:
        """Ask the cable who it is; the gauge on it does not tell."""
        async with self._replies.turn():
            manufacturer, product, serial = await self._port.texts()
            device = await self._ask_device()
        return DeviceIdentity(
            manufacturer or "Mitutoyo", product or "USB-ITN", serial or "unknown", device.text or "unknown"
        )

    async def read(self) -> BallbarReading:
        """Ask the gauge for what it displays; a gauge that says nothing is a reading without a signal."""
        async with self._replies.turn():
            reply = await self._ask_value()
            if isinstance(reply, Value):
                reply = await self._in_form(reply)
        time_s, resolution_mm = await self._clock.now_s(), self._form.resolution_mm
        if isinstance(reply, protocol.Error):
            return BallbarReading(math.nan, "none", resolution_mm, time_s)
        # Half a step more: the end of the range is within it, whatever a double makes of it.
        inside = abs(reply.shown) <= self._range_mm + 0.5 * resolution_mm
        return BallbarReading(reply.shown, "good" if inside else "out_of_range", resolution_mm, time_s)

    async def _in_form(self, value: Value) -> Value:
        """Return a value of the form of all others; raises ItnProtocolError."""
        for _ in range(MOST_LESSONS):
            if self._form.known:
                break
            again = await self._ask_value()
            if not isinstance(again, Value):
                break
            self._form.learn(value, again)
            value = again
        self._form.require(value)
        return value

    async def _ask_value(self) -> Value | protocol.Error:
        """Ask for the value; what was sent before the question is passed over, whoever made it be sent.

        Where a second line comes behind the first nobody knows which is the answer: it is asked for again.
        """
        for _ in range(_MOST_TRIES):
            await self._ask_device()
            await self._send(protocol.READ_VALUE)
            reply = await self._replies.next()
            if isinstance(reply, protocol.DeviceInfo):
                raise protocol.ItnProtocolError(
                    f"the cable told about itself ({reply.text!r}) when asked for a value"
                )
            if await self._replies.is_quiet():
                return reply
        raise protocol.ItnProtocolError(
            f"the cable at {self._port.address} sends data without a request: do not press keys on the gauge"
        )

    async def _ask_device(self) -> protocol.DeviceInfo:
        """Ask who it is. No value looks like the answer, so whatever stands before it was sent earlier."""
        await self._send(protocol.READ_DEVICE)
        while True:
            reply = await self._replies.next()
            if isinstance(reply, protocol.DeviceInfo):
                return reply

    async def _send(self, command: bytes) -> None:
        silence = (
            f"the cable at {self._port.address} does not respond: {_PLUG}, and check the gauge's battery"
        )
        self._replies.expect(self._reply_timeout_s, silence)
        await self._port.control_out(VENDOR_TO_DEVICE, protocol.SEND_COMMAND, data=command)


def _open(options: Options, clock: Clock) -> UsbItnGauge:
    where = usb_address(options, default=_ANY_CABLE)
    range_mm = option.positive(options, "range_mm", _RANGE_MM)
    return UsbItnGauge(UsbDevice(where), clock, range_mm=range_mm, decimals=decimals_option(options))


_OPTIONS = {
    "usb": f"vendor:product[:serial number], default {_ANY_CABLE}, or usbip://host[:port]/busid",
    "host": "instead of usb: address of a USB/IP server whose only device it is",
    "port": "TCP port of the USB/IP server, default 3240",
    "range_mm": "range to either side of zero; values beyond it are out of range; default 1.0",
    "decimals": "decimal places in millimetres; default: taken from the first values",
}
PLUGIN = DriverPlugin("mitutoyo_usb_itn", "ballbar", "usb_itn", _OPTIONS, _open, also=("linear_gauge",))
