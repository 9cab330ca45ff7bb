"""An imported USB device on a USB/IP connection: transfers, one at a time, each with its time-out.

A transfer that times out is taken back before anything else happens, so that a late one never answers a
later request; one that completed in that very moment counts.
"""

import contextlib
import errno
import itertools
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass

import usb.core

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.transports.tcp import watch_peer
from truepose_drivers.usb import protocol, usbip
from truepose_drivers.usb.protocol import FROM_DEVICE, Setup, StandardRequest, encode_setup

_CONNECT_TIMEOUT_S = 5.0
_OPERATION_TIMEOUT_S = 5.0  # of requests that no device has a part in
_UNLINK_TIMEOUT_S = 2.0
_CONTROL_TIMEOUT_MS = 1000


def listed_devices(host: str, port: int) -> list["RemoteDevice"]:
    """Ask a server for its devices; raises USBError where nobody answers."""
    with _connection(host, port) as stream:
        return [RemoteDevice(host, port, record) for record in stream.list_devices()]


@dataclass(slots=True)
class RemoteDevice:
    """A device of a server, with what it once said of itself."""

    host: str
    port: int
    record: usbip.DeviceRecord
    _device: protocol.Device | None = None
    _configurations: tuple[protocol.Configuration, ...] = ()

    def open(self) -> "Session":
        """Import it on a connection of its own."""
        stream = _connection(self.host, self.port)
        try:
            return Session(stream, stream.import_device(self.record.busid))
        except BaseException:
            stream.close()
            raise

    def device_descriptor(self) -> protocol.Device:
        """Return its device descriptor; the device is imported for the moment that takes."""
        if self._device is None:
            session = self.open()
            try:
                self._device, self._configurations = session.describe()
            finally:
                session.close()
        return self._device

    def configuration(self, number: int) -> protocol.Configuration:
        """Return one of its configurations, from 0; raises IndexError."""
        self.device_descriptor()
        return self._configurations[number]


class Session:
    """An imported device: transfers, one at a time."""

    def __init__(self, stream: "_Stream", record: usbip.DeviceRecord) -> None:
        self._stream = stream
        self._record = record
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    def close(self) -> None:
        """End the connection, which gives the device back."""
        self._stream.close()

    def control(self, setup: Setup, data: bytes = b"", timeout_ms: int = _CONTROL_TIMEOUT_MS) -> bytes:
        """Make a control transfer and return what the device sent."""
        return self._transfer(0, setup.is_in, setup.length, data, timeout_ms, encode_setup(setup)).data

    def read(self, endpoint: int, length: int, timeout_ms: int) -> bytes:
        """Read an endpoint."""
        return self._transfer(endpoint & 0x0F, True, length, b"", timeout_ms).data

    def write(self, endpoint: int, data: bytes, timeout_ms: int) -> int:
        """Write to an endpoint; returns how many bytes the device took."""
        return self._transfer(endpoint & 0x0F, False, len(data), data, timeout_ms).length

    def describe(self) -> tuple[protocol.Device, tuple[protocol.Configuration, ...]]:
        """Ask the device for its descriptors."""
        kind = protocol.DescriptorType
        with _translated():
            device = protocol.decode_device(self._descriptor(kind.DEVICE, 0, protocol.DEVICE_BYTES))
            configurations = []
            for number in range(device.configurations):
                head = self._descriptor(kind.CONFIGURATION, number, protocol.CONFIGURATION_HEAD_BYTES)
                total = protocol.configuration_total_bytes(head)
                whole = self._descriptor(kind.CONFIGURATION, number, total)
                configurations.append(protocol.decode_configuration(whole))
        return device, tuple(configurations)

    def _descriptor(self, kind: int, number: int, length: int) -> bytes:
        value = kind << 8 | number
        return self.control(Setup(FROM_DEVICE, StandardRequest.GET_DESCRIPTOR, value, 0, length))

    def _transfer(
        self, endpoint: int, is_in: bool, length: int, data: bytes, timeout_ms: int, setup: bytes = bytes(8)
    ) -> usbip.SubmitReply:
        with self._lock, _translated():
            sequence = next(self._numbers)
            request = usbip.Submit(sequence, self._record.id, endpoint, is_in, length, setup, data)
            self._stream.send(usbip.encode_request(request))
            timeout_s = timeout_ms / 1000.0 if timeout_ms else None  # 0: as long as it takes, as in libusb
            reply = self._reply(is_in, timeout_s) or self._take_back(sequence, is_in)
            if reply.status:
                raise _error(-reply.status)
            return reply

    def _reply(self, is_in: bool, timeout_s: float | None) -> usbip.SubmitReply | None:
        """Return the reply to the one transfer under way, None after `timeout_s`."""
        header = self._stream.receive(usbip.HEADER_BYTES, timeout_s)
        if header is None:
            return None
        reply = usbip.decode_reply(header)
        if not isinstance(reply, usbip.SubmitReply):
            raise usbip.UsbipProtocolError(
                "a transfer was answered as cancelled without a request to cancel it"
            )
        data = self._stream.receive_rest(reply.length) if is_in and reply.length else b""
        return usbip.SubmitReply(reply.sequence, reply.status, reply.length, data)

    def _take_back(self, victim: int, is_in: bool) -> usbip.SubmitReply:
        """Give a transfer up; return it if it completed all the same, else raise USBTimeoutError."""
        unlink = usbip.Unlink(next(self._numbers), self._record.id, victim)
        self._stream.send(usbip.encode_request(unlink))
        completed: usbip.SubmitReply | None = None
        while True:
            header = self._stream.receive(usbip.HEADER_BYTES, _UNLINK_TIMEOUT_S)
            if header is None:
                raise _error(errno.ENODEV)  # not even the server answers
            match usbip.decode_reply(header):
                case usbip.SubmitReply(sequence, status, length):
                    data = self._stream.receive_rest(length) if is_in and length else b""
                    completed = usbip.SubmitReply(sequence, status, length, data)
                case usbip.UnlinkReply():
                    break
        if completed is None or completed.status == usbip.UNLINKED:
            raise usb.core.USBTimeoutError("the device did not respond in time", None, errno.ETIMEDOUT)
        return completed


class _Stream:
    """A blocking TCP connection to a USB/IP server."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection

    def __enter__(self) -> "_Stream":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close it."""
        self._connection.close()

    def send(self, data: bytes) -> None:
        """Send all of `data`."""
        self._connection.settimeout(_OPERATION_TIMEOUT_S)
        self._connection.sendall(data)

    def receive(self, length: int, timeout_s: float | None) -> bytes | None:
        """Return the next `length` bytes, None when none of them comes in time."""
        self._connection.settimeout(timeout_s)
        try:
            first = self._connection.recv(length)
        except TimeoutError:
            return None
        if not first:
            raise ConnectionResetError(errno.ECONNRESET, "the server closed the connection")
        return first + self.receive_rest(length - len(first))

    def receive_rest(self, length: int) -> bytes:
        """Return the next `length` bytes of a message that has begun."""
        self._connection.settimeout(_OPERATION_TIMEOUT_S)
        data = b""
        while len(data) < length:
            piece = self._connection.recv(length - len(data))
            if not piece:
                raise ConnectionResetError(
                    errno.ECONNRESET, "the server closed the connection during a message"
                )
            data += piece
        return data

    def list_devices(self) -> list[usbip.DeviceRecord]:
        """Ask for the list of devices."""
        with _translated():
            self._ask(usbip.LIST_REQUEST, b"", usbip.LIST_REPLY)
            records = []
            for _ in range(usbip.decode_count(self.receive_rest(usbip.COUNT_BYTES))):
                record = usbip.decode_record(self.receive_rest(usbip.RECORD_BYTES))
                self.receive_rest(record.interfaces * usbip.INTERFACE_BYTES)
                records.append(record)
        return records

    def import_device(self, busid: str) -> usbip.DeviceRecord:
        """Take a device over; raises USBError where it is not there or somebody else has it."""
        with _translated():
            status = self._ask(usbip.IMPORT_REQUEST, usbip.encode_busid(busid), usbip.IMPORT_REPLY)
            if status == usbip.OK:
                return usbip.decode_record(self.receive_rest(usbip.RECORD_BYTES))
        raise _error(errno.ENODEV if status == usbip.NO_DEVICE else errno.EBUSY)

    def _ask(self, request: int, body: bytes, reply: int) -> int:
        self.send(usbip.encode_operation(usbip.Operation(request)) + body)
        answer = usbip.decode_operation(self.receive_rest(usbip.OPERATION_BYTES))
        if answer.code != reply:
            raise usbip.UsbipProtocolError(f"request 0x{request:04x} was answered 0x{answer.code:04x}")
        return answer.status


@contextlib.contextmanager
def _translated() -> Iterator[None]:
    """Turn what sockets and codec raise into pyusb's errors."""
    try:
        yield
    except usb.core.USBError:  # an OSError itself
        raise
    except RemoteProtocolError as error:
        raise usb.core.USBError(str(error), None, errno.EPROTO) from error
    except OSError as error:
        raise _error(errno.ENODEV) from error


def _connection(host: str, port: int) -> _Stream:
    try:
        connection = socket.create_connection((host, port), _CONNECT_TIMEOUT_S)
    except OSError as error:
        reason = error.strerror or str(error)
        raise usb.core.USBError(f"no connection to {host}:{port} ({reason})", None, errno.ENODEV) from error
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    watch_peer(connection)
    return _Stream(connection)


def _error(number: int) -> usb.core.USBError:
    texts = {
        errno.ENODEV: "the device was disconnected",
        errno.EPIPE: "the device refuses the request",
        errno.EBUSY: "the device is in use or not exported",
    }
    return usb.core.USBError(texts.get(number, f"transfer failed with status {-number}"), None, number)
