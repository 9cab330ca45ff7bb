"""A simulated USB device, and a USB/IP server with it: for our drivers, other clients or a Linux kernel.

Interrupt transfers wait until the device has a packet; whoever waits may give up. While the device's cable is
out it is not listed, cannot be imported, and a connection that had it ends.
"""

import asyncio
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Protocol

from truepose_drivers.usb import protocol as usb
from truepose_drivers.usb import usbip
from truepose_drivers.usb.usbip import Operation, Reply, Submit, SubmitReply, Unlink, UnlinkReply
from truepose_simulators.instruments.endpoint import Endpoint

_SELF_POWERED_NO_WAKEUP = bytes(2)


class StallError(Exception):
    """The device refuses a request by stalling the endpoint."""


class UsbGadget(Protocol):
    """A device as a bus sees it."""

    @property
    def device(self) -> usb.Device:
        """Its device descriptor."""

    @property
    def configuration(self) -> usb.Configuration:
        """Its only configuration."""

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""

    def attach(self) -> None:
        """Begin anew, as after a reset of the bus."""

    def control(self, setup: usb.Setup, data: bytes) -> bytes:
        """Answer a control transfer; raises StallError."""

    async def ready(self) -> None:
        """Return when the interrupt endpoint has a packet."""

    def take_packet(self) -> bytes:
        """Return the packet that `ready` waited for."""


class StandardRequests:
    """Answers what every HID device answers in the same way."""

    def __init__(
        self,
        device: usb.Device,
        configuration: usb.Configuration,
        strings: tuple[str, ...],
        report_descriptor: bytes,
    ) -> None:
        self._configuration = configuration
        (interface,) = configuration.interfaces
        self._device_descriptors: dict[tuple[int, int], bytes] = {
            (usb.DescriptorType.DEVICE, 0): usb.encode_device(device),
            (usb.DescriptorType.CONFIGURATION, 0): usb.encode_configuration(configuration),
            (usb.DescriptorType.STRING, 0): usb.encode_languages(),
        }
        self.reset(strings)
        self._interface_descriptors: Mapping[tuple[int, int], bytes] = {
            (usb.DescriptorType.HID, 0): usb.encode_hid(interface),
            (usb.DescriptorType.REPORT, 0): report_descriptor,
        }
        self._answers: Mapping[tuple[int, int], Callable[[usb.Setup], bytes]] = {
            (usb.FROM_DEVICE, usb.StandardRequest.GET_DESCRIPTOR): lambda setup: _found(
                self._device_descriptors, setup
            ),
            (usb.FROM_INTERFACE, usb.StandardRequest.GET_DESCRIPTOR): lambda setup: _found(
                self._interface_descriptors, setup
            ),
            (usb.FROM_DEVICE, usb.StandardRequest.GET_STATUS): lambda _: _SELF_POWERED_NO_WAKEUP,
            (usb.FROM_INTERFACE, usb.StandardRequest.GET_STATUS): lambda _: bytes(2),
            (usb.FROM_ENDPOINT, usb.StandardRequest.GET_STATUS): lambda _: bytes(2),
            (usb.FROM_DEVICE, usb.StandardRequest.GET_CONFIGURATION): lambda _: bytes([self._chosen]),
            (usb.TO_DEVICE, usb.StandardRequest.SET_CONFIGURATION): self._choose,
            (usb.TO_DEVICE, usb.StandardRequest.SET_ADDRESS): lambda _: b"",
            (usb.FROM_INTERFACE, usb.StandardRequest.GET_INTERFACE): lambda _: bytes(1),
            (usb.TO_INTERFACE, usb.StandardRequest.SET_INTERFACE): _only_first,
            (usb.TO_ENDPOINT, usb.StandardRequest.CLEAR_FEATURE): lambda _: b"",
        }

    def answer(self, setup: usb.Setup) -> bytes:
        """Answer a standard request; raises StallError for one that is none, or not known."""
        answer = self._answers.get((setup.request_type, setup.request))
        if answer is None:
            raise StallError
        return answer(setup)[: setup.length]

    def reset(self, strings: tuple[str, ...]) -> None:
        """Forget the chosen configuration; another device may be plugged in by now, with its own texts."""
        self._chosen = 0
        texts = enumerate(strings, start=1)
        self._device_descriptors |= {
            (usb.DescriptorType.STRING, number): usb.encode_string(text) for number, text in texts
        }

    def _choose(self, setup: usb.Setup) -> bytes:
        if setup.value not in (0, self._configuration.value):
            raise StallError
        self._chosen = setup.value
        return b""


def _found(descriptors: Mapping[tuple[int, int], bytes], setup: usb.Setup) -> bytes:
    kind, number = divmod(setup.value, 256)
    if (kind, number) not in descriptors:
        raise StallError
    return descriptors[kind, number]


def _only_first(setup: usb.Setup) -> bytes:
    if setup.value or setup.index:
        raise StallError
    return b""


BUSID = "1-1"
_BUS, _NUMBER, _FULL_SPEED = 1, 2, 2
_PATH = "/sys/devices/simulated/usb1/1-1"
_TOO_MUCH = -75  # EOVERFLOW: the packet is longer than what was asked for
_LOOK_S = 0.02  # how often the cable is looked at
_HANDING_OVER_S = 0.5  # a client that connects again may be faster than the end of its last connection


class UsbipServer:
    """One device and who has it."""

    def __init__(self, gadget: UsbGadget) -> None:
        self._gadget = gadget
        self._taken = asyncio.Lock()

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Attend to one connection: a list, or an import with its transfers."""
        try:
            operation = usbip.decode_operation(await reader.readexactly(usbip.OPERATION_BYTES))
            if operation.code == usbip.LIST_REQUEST:
                writer.write(self._list())
                await writer.drain()
            elif operation.code == usbip.IMPORT_REQUEST:
                busid = usbip.decode_busid(await reader.readexactly(usbip.BUSID_BYTES))
                await self._import(busid, reader, writer)
        except (asyncio.IncompleteReadError, usbip.UsbipProtocolError):
            return  # the client has gone, or speaks something else: there is nobody to tell

    def _list(self) -> bytes:
        head = usbip.encode_operation(Operation(usbip.LIST_REPLY))
        if not self._gadget.plugged:
            return head + usbip.encode_count(0)
        interfaces = (
            usbip.encode_interface(interface.interface_class, interface.subclass, interface.protocol)
            for interface in self._gadget.configuration.interfaces
        )
        return head + usbip.encode_count(1) + usbip.encode_record(self._record()) + b"".join(interfaces)

    def _record(self) -> usbip.DeviceRecord:
        device, configuration = self._gadget.device, self._gadget.configuration
        return usbip.DeviceRecord(
            path=_PATH,
            busid=BUSID,
            bus=_BUS,
            number=_NUMBER,
            speed=_FULL_SPEED,
            vendor=device.vendor,
            product=device.product,
            release=device.release,
            device_class=device.device_class,
            device_subclass=device.device_subclass,
            device_protocol=device.device_protocol,
            configuration=configuration.value,
            configurations=device.configurations,
            interfaces=len(configuration.interfaces),
        )

    async def _import(self, busid: str, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if busid != BUSID or not self._gadget.plugged:
            writer.write(_refusal(usbip.NO_DEVICE))
            return
        try:
            async with asyncio.timeout(_HANDING_OVER_S):
                await self._taken.acquire()
        except TimeoutError:
            writer.write(_refusal(usbip.BUSY))
            return
        try:
            writer.write(usbip.encode_operation(Operation(usbip.IMPORT_REPLY)))
            writer.write(usbip.encode_record(self._record()))
            self._gadget.attach()
            await self._while_plugged(Transfers(self._gadget, reader, writer))
        finally:
            self._taken.release()

    async def _while_plugged(self, transfers: "Transfers") -> None:
        tasks = {
            asyncio.create_task(transfers.take_requests()),
            asyncio.create_task(transfers.send_packets()),
            asyncio.create_task(self._unplugged()),
        }
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        for task in done:
            task.result()

    async def _unplugged(self) -> None:
        while self._gadget.plugged:
            await asyncio.sleep(_LOOK_S)


class Transfers:
    """The transfers of a connection that has imported the device."""

    def __init__(self, gadget: UsbGadget, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._gadget = gadget
        self._reader = reader
        self._writer = writer
        (interface,) = gadget.configuration.interfaces
        self._endpoints = {endpoint.address & 0x0F for endpoint in interface.endpoints}
        self._waiting: OrderedDict[int, Submit] = OrderedDict()  # interrupt transfers, oldest first
        self._somebody_waits = asyncio.Event()

    async def take_requests(self) -> None:
        """Answer requests until the client hangs up."""
        while True:
            request, length = usbip.decode_request(await self._reader.readexactly(usbip.HEADER_BYTES))
            data = await self._reader.readexactly(length)
            match request:
                case Unlink(sequence, _, victim):
                    given_up = self._waiting.pop(victim, None)
                    self._send(UnlinkReply(sequence, usbip.UNLINKED if given_up else 0))
                case Submit(endpoint=0):
                    self._send(self._control(request, data))
                case Submit(sequence, _, endpoint, True) if endpoint in self._endpoints:
                    self._waiting[sequence] = request
                    self._somebody_waits.set()
                case Submit(sequence):
                    self._send(SubmitReply(sequence, usbip.STALLED, 0))
            await self._writer.drain()

    async def send_packets(self) -> None:
        """Hand packets to whoever waits, first come, first served."""
        while True:
            await self._somebody_waits.wait()
            await self._gadget.ready()
            if not self._waiting:
                self._somebody_waits.clear()  # they gave up; the packet stays with the device
                continue
            sequence, request = self._waiting.popitem(last=False)
            packet = self._gadget.take_packet()
            status = 0 if len(packet) <= request.length else _TOO_MUCH
            sent = packet[: request.length]
            self._send(SubmitReply(sequence, status, len(sent), sent))
            await self._writer.drain()

    def _control(self, request: Submit, data: bytes) -> Reply:
        setup = usb.decode_setup(request.setup)
        if (setup.request_type, setup.request) == (usb.CLASS_TO_PORT, usb.StandardRequest.SET_FEATURE):
            return self._reset_port(request.sequence, setup)
        try:
            answer = self._gadget.control(setup, data)
        except StallError:
            return SubmitReply(request.sequence, usbip.STALLED, 0)
        if not request.is_in:
            return SubmitReply(request.sequence, 0, len(data))
        return SubmitReply(request.sequence, 0, len(answer), answer)

    def _reset_port(self, sequence: int, setup: usb.Setup) -> Reply:
        if setup.value != usb.PORT_RESET:
            return SubmitReply(sequence, usbip.STALLED, 0)
        self._gadget.attach()
        return SubmitReply(sequence, 0, 0)

    def _send(self, reply: Reply) -> None:
        self._writer.write(usbip.encode_reply(reply))


def usbip_endpoint(protocol: str, gadget: UsbGadget) -> Endpoint:
    """Build the endpoint of a ballbar that is a USB device; `protocol` is what the device speaks."""
    return Endpoint("ballbar", protocol, UsbipServer(gadget).serve)


def _refusal(status: int) -> bytes:
    return usbip.encode_operation(Operation(usbip.IMPORT_REPLY, status))
