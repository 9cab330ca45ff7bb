"""A USB device through the whole of pyusb and our USB/IP back end, against scripted servers on loopback."""

import asyncio
import contextlib
import errno
import threading

import pytest
import usb.core

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, DeviceRefusedError, NoReplyError
from truepose_drivers.transports.usb import LocalUsb, RemoteUsb, UsbDevice
from truepose_drivers.transports.usbip_backend import UsbipBackend
from truepose_drivers.usb import usbip
from truepose_drivers.usb.protocol import Configuration, Device, Interface, Setup, decode_setup
from truepose_drivers.usb.protocol import Endpoint as UsbEndpoint
from truepose_drivers.usb.usbip import Operation, Submit, SubmitReply, Unlink, UnlinkReply
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.usbip import StallError, StandardRequests, UsbipServer

STRINGS = ("Maker", "Thing", "SN-1")


class FakeGadget:
    """A device with one interrupt endpoint; the test says which packets it has."""

    def __init__(self, endpoint: UsbEndpoint | None = None) -> None:
        self.device = Device(0x1209, 0x0002, 0x0100)
        endpoints = (endpoint or UsbEndpoint(0x81, 3, 8, 1),)
        self.configuration = Configuration(1, (Interface(0, 3, 0, 0, endpoints, report_descriptor_bytes=3),))
        self.plugged = True
        self.mute = False  # tells none of its texts
        self.packets: asyncio.Queue[bytes] = asyncio.Queue()
        self.heard: list[tuple[Setup, bytes]] = []
        self.attached = 0
        self._standard = StandardRequests(self.device, self.configuration, STRINGS, b"\x05\x01\xc0")

    def attach(self) -> None:
        self.attached += 1

    def control(self, setup: Setup, data: bytes) -> bytes:
        if setup.request_type in (0x40, 0xC0):
            self.heard.append((setup, data))
            if setup.request == 99:
                raise StallError
            return b"\x2a"
        if self.mute and setup.value >> 8 == 3:
            raise StallError
        return self._standard.answer(setup)

    async def ready(self) -> None:
        while self.packets.empty():
            await asyncio.sleep(0.001)

    def take_packet(self) -> bytes:
        return self.packets.get_nowait()


@contextlib.asynccontextmanager
async def served(serve):
    """Serve on a free port in this loop; yields the port."""
    endpoint = Endpoint("thing", "usbip", serve)
    yield (await endpoint.open("127.0.0.1", 0)).port
    await endpoint.close()


@pytest.fixture
def gadget() -> FakeGadget:
    return FakeGadget()


@pytest.fixture
async def device(gadget):
    async with served(UsbipServer(gadget).serve) as port:
        device = UsbDevice(RemoteUsb("127.0.0.1", port, "1-1"))
        await device.open()
        yield device
        await device.close()


async def test_texts_and_requests_go_there_and_back(gadget, device):
    assert await device.texts() == STRINGS
    await device.control_out(0x40, 3, 0xA5A5, 7, b"1\r")
    assert await device.control_in(0xC0, 2, 0, 0, 1) == b"\x2a"

    assert gadget.heard == [(Setup(0x40, 3, 0xA5A5, 7, 2), b"1\r"), (Setup(0xC0, 2, 0, 0, 1), b"")]


async def test_packets_arrive_in_order(gadget, device):
    for packet in (b"01A+0000", b".1234\r"):
        gadget.packets.put_nowait(packet)

    assert [await device.receive(1.0) for _ in range(2)] == [b"01A+0000", b".1234\r"]


async def test_a_wait_in_vain_is_taken_back_and_loses_nothing(gadget, device):
    assert await device.receive(0.05) is None
    assert await device.receive(0.0) is None
    gadget.packets.put_nowait(b"late")

    assert await device.receive(1.0) == b"late"


async def test_a_packet_that_comes_while_it_is_waited_for_arrives(gadget, device):
    asyncio.get_running_loop().call_later(0.15, gadget.packets.put_nowait, b"now")

    assert await device.receive(2.0) == b"now"


async def test_a_refused_request_is_a_refusal_and_the_device_stays(device):
    with pytest.raises(DeviceRefusedError, match="refuses a request"):
        await device.control_out(0x40, 99)

    assert device.is_open
    assert await device.texts() == STRINGS


async def test_a_packet_longer_than_asked_for_is_an_error_not_a_piece(gadget, device):
    gadget.packets.put_nowait(b"123456789")

    with pytest.raises(ConnectionLostError):
        await device.receive(1.0)


async def test_a_pulled_cable_is_a_lost_connection_until_it_is_back(gadget, device):
    gadget.plugged = False

    with pytest.raises(ConnectionLostError, match="check its cable"):
        await device.receive(1.0)
    assert not device.is_open
    with pytest.raises(ConnectFailedError, match="check its cable"):
        await device.open()
    gadget.plugged = True
    await device.open()

    assert await device.texts() == STRINGS


async def test_a_cable_that_is_pulled_before_the_texts_are_asked_for_is_a_lost_connection():
    async with served(UsbipServer(FakeGadget()).serve) as port:
        device = UsbDevice(RemoteUsb("127.0.0.1", port, "1-1"))
        await device.open()

    with pytest.raises(ConnectionLostError, match="check its cable"):  # pyusb itself says: no langid
        await device.texts()

    assert not device.is_open


async def test_a_device_without_texts_has_empty_ones(gadget, device):
    gadget.mute = True

    assert await device.texts() == ("", "", "")
    assert device.is_open


async def test_a_device_that_somebody_has_is_told():
    gadget = FakeGadget()
    async with served(UsbipServer(gadget).serve) as port:
        first, second = (UsbDevice(RemoteUsb("127.0.0.1", port, "1-1")) for _ in range(2))
        await first.open()

        with pytest.raises(ConnectFailedError, match="no other program is using it"):
            await second.open()
        await first.close()
        await second.open()

        await second.close()


async def test_the_server_that_has_another_device_is_told_from_none():
    async with served(UsbipServer(FakeGadget()).serve) as port:
        with pytest.raises(ConnectFailedError, match="no USB device usbip://127"):
            await UsbDevice(RemoteUsb("127.0.0.1", port, "1-2")).open()
    with pytest.raises(ConnectFailedError, match="check cable and address"):
        await UsbDevice(RemoteUsb("127.0.0.1", port, "1-1")).open()


async def test_a_server_of_something_else_is_told():
    async def serve(reader, writer):
        writer.write(b"HTTP/1.1 400 Bad Request\r\n\r\n")

    async with served(serve) as port:
        with pytest.raises(ConnectFailedError, match="is not USB/IP"):
            await UsbDevice(RemoteUsb("127.0.0.1", port, "1-1")).open()


async def test_a_device_without_an_interrupt_endpoint_is_told():
    gadget = FakeGadget(UsbEndpoint(0x02, 3, 8, 1))
    async with served(UsbipServer(gadget).serve) as port:
        with pytest.raises(ConnectFailedError, match="no interrupt endpoint"):
            await UsbDevice(RemoteUsb("127.0.0.1", port, "1-1")).open()


async def test_a_device_of_this_computer_that_is_not_there_is_told():
    # a machine without USB, with libusb or without: either is a sentence
    with pytest.raises(ConnectFailedError, match=r"ffff:fffe.*(check its cable|libusb)"):
        await UsbDevice(LocalUsb(0xFFFF, 0xFFFE, "x")).open()


class ScriptedServer:
    """Imports whatever is asked for, then answers interrupt transfers by what the test says."""

    def __init__(self, gadget: FakeGadget, answers) -> None:
        self._server = UsbipServer(gadget)
        self._gadget = gadget
        self._answers = answers

    async def serve(self, reader, writer) -> None:
        operation = usbip.decode_operation(await reader.readexactly(usbip.OPERATION_BYTES))
        if operation.code == usbip.LIST_REQUEST:
            writer.write(self._server._list())
            return
        await reader.readexactly(usbip.BUSID_BYTES)
        writer.write(usbip.encode_operation(Operation(usbip.IMPORT_REPLY)))
        writer.write(usbip.encode_record(self._server._record()))
        while True:
            try:
                header = await reader.readexactly(usbip.HEADER_BYTES)
            except asyncio.IncompleteReadError:
                return
            request, length = usbip.decode_request(header)
            data = await reader.readexactly(length)
            for reply in self._reply(request, data):
                writer.write(usbip.encode_reply(reply))

    def _reply(self, request, data):
        if isinstance(request, Submit) and request.endpoint == 0:
            try:
                answer = self._gadget.control(decode_setup(request.setup), data)
            except StallError:
                return [SubmitReply(request.sequence, -32, 0)]
            return [SubmitReply(request.sequence, 0, len(answer) if request.is_in else len(data), answer)]
        return self._answers(request)


@contextlib.asynccontextmanager
async def scripted(answers):
    async with served(ScriptedServer(FakeGadget(), answers).serve) as port:
        device = UsbDevice(RemoteUsb("127.0.0.1", port, "1-1"))
        await device.open()
        yield device
        await device.close()


async def test_a_packet_that_completes_while_it_is_given_up_counts():
    def answers(request):
        if isinstance(request, Unlink):  # the packet was on its way already
            return [SubmitReply(request.victim, 0, 4, b"race"), UnlinkReply(request.sequence, 0)]
        return []

    async with scripted(answers) as device:
        assert await device.receive(0.05) == b"race"


async def test_a_server_that_answers_given_up_transfers_itself_is_understood():
    def answers(request):
        if isinstance(request, Unlink):
            return [SubmitReply(request.victim, -104, 0), UnlinkReply(request.sequence, -104)]
        return []

    async with scripted(answers) as device:
        assert await device.receive(0.05) is None
        assert device.is_open


async def test_a_device_that_reports_itself_gone_is_gone():
    async with scripted(lambda request: [SubmitReply(request.sequence, -19, 0)]) as device:
        with pytest.raises(ConnectionLostError):
            await device.receive(1.0)
        assert not device.is_open


async def test_a_reply_of_another_protocol_in_mid_session_is_a_lost_connection():
    async with scripted(lambda request: [UnlinkReply(request.sequence, 0)]) as device:
        with pytest.raises(ConnectionLostError, match="without a request to cancel it"):
            await device.receive(1.0)


async def test_a_control_transfer_that_is_never_answered_is_told():
    gadget = FakeGadget()
    silent = threading.Event()

    def answers(request):
        return [UnlinkReply(request.sequence, -104)] if isinstance(request, Unlink) else []

    server = ScriptedServer(gadget, answers)
    plain = server._reply
    server._reply = lambda request, data: (
        answers(request) if silent.is_set() or isinstance(request, Unlink) else plain(request, data)
    )
    async with served(server.serve) as port:
        device = UsbDevice(RemoteUsb("127.0.0.1", port, "1-1"))
        await device.open()
        silent.set()

        with pytest.raises(NoReplyError, match="does not answer"):
            await device.control_in(0xC0, 2, 0, 0, 1)
        await device.close()


async def test_errors_carry_the_numbers_that_libusb_gives():
    gadget = FakeGadget()
    async with served(UsbipServer(gadget).serve) as port:
        found = await asyncio.to_thread(lambda: usb.core.find(backend=UsbipBackend("127.0.0.1", port)))
        assert await asyncio.to_thread(lambda: found.serial_number) == "SN-1"
        await asyncio.to_thread(found.set_configuration)
        endpoint = await asyncio.to_thread(lambda: found[0][(0, 0)][0])

        with pytest.raises(usb.core.USBTimeoutError) as silent:
            await asyncio.to_thread(endpoint.read, 8, 20)
        with pytest.raises(usb.core.USBError) as stalled:
            await asyncio.to_thread(found.ctrl_transfer, 0x40, 99)
        gadget.plugged = False
        await asyncio.sleep(0.05)
        with pytest.raises(usb.core.USBError) as gone:
            await asyncio.to_thread(endpoint.read, 8, 1000)
        await asyncio.to_thread(usb.util.dispose_resources, found)

    assert (silent.value.errno, stalled.value.errno, gone.value.errno) == (
        errno.ETIMEDOUT,
        errno.EPIPE,
        errno.ENODEV,
    )
