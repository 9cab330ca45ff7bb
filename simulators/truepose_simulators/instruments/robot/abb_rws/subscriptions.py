"""Subscriptions of web services: whoever asks for resources is told their changes on a WebSocket.

RFC 6455, as far as a server needs it that speaks short texts and listens for the end only.
"""

import asyncio
import base64
import hashlib
from collections.abc import Mapping
from typing import Final, Protocol

from truepose_drivers.abb_rws.protocol import resources
from truepose_drivers.abb_rws.protocol.http import HttpRequest, HttpResponse
from truepose_simulators.instruments.robot.abb_rws.answers import Answers, NotFoundError

POLL: Final = "/poll/"
_SUB_PROTOCOL: Final = "robapi2_subscription"
_GUID: Final = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_LOOK_S: Final = 0.05  # wall time: who listens knows no other
_TEXT_FRAME, _SHORT, _LENGTH_16 = 0x81, 125, 126
_CHUNK_BYTES: Final = 4096

# Of a subscribed path: class of its events, and of the value in them.
_CLASSES: Final[Mapping[str, tuple[str, str]]] = {
    resources.CONTROLLER_STATE: ("pnl-ctrlstate-ev", "ctrlstate"),
    resources.OPERATION_MODE: ("pnl-opmode-ev", "opmode"),
    resources.EXECUTION: ("rap-ctrlexecstate-ev", "ctrlexecstate"),
    resources.SYMBOL_DATA: ("rap-data", "value"),
    "/rw/iosystem/signals/": ("ios-signalstate-ev", "lvalue"),
}


class Writer(Protocol):
    """What is needed of a stream."""

    def write(self, data: bytes) -> None:
        """Hand over `data`."""

    async def drain(self) -> None:
        """Wait until it is gone."""


class Subscriptions:
    """All subscriptions of one controller's clients."""

    def __init__(self, answers: Answers) -> None:
        self._answers = answers
        self._resources: list[list[str]] = []

    def add(self, request: HttpRequest) -> HttpResponse:
        """Note what a client wants to be told; raises NotFoundError, RwsProtocolError."""
        wanted = [value for name, value in request.form.items() if name.isdigit()]
        for resource in wanted:
            self._value(resource)
        self._resources.append(wanted)
        at = f"ws://{request.headers['host']}{POLL}{len(self._resources)}"
        headers = (("location", at), ("content-type", "application/xhtml+xml"))
        return HttpResponse(201, headers, f'<a href="{at}" rel="self"></a>'.encode())

    def handshake(self, request: HttpRequest) -> HttpResponse:
        """Return the answer to a client that comes to listen; raises NotFoundError."""
        key = request.headers.get("sec-websocket-key")
        if key is None:
            raise NotFoundError("this is a place for WebSockets")
        digest = hashlib.sha1((key + _GUID).encode(), usedforsecurity=False).digest()
        headers = {
            "upgrade": "websocket",
            "connection": "Upgrade",
            "sec-websocket-accept": base64.b64encode(digest).decode(),
            "sec-websocket-protocol": _SUB_PROTOCOL,
        }
        return HttpResponse(101, tuple(headers.items()))

    async def tell(self, path: str, reader: asyncio.StreamReader, writer: Writer) -> None:
        """Tell every change of what was subscribed until the client says or does that it goes."""
        number = path.removeprefix(POLL)
        wanted = self._resources[int(number) - 1] if number.isdigit() else []
        told = {resource: self._value(resource) for resource in wanted}
        leaving = asyncio.ensure_future(reader.read(_CHUNK_BYTES))
        try:
            while not leaving.done():
                for resource in wanted:
                    value = self._value(resource)
                    if value != told[resource]:
                        told[resource] = value
                        writer.write(text_frame(_event(resource, value)))
                await writer.drain()
                await asyncio.wait({leaving}, timeout=_LOOK_S)
            await leaving
        finally:
            leaving.cancel()

    def _value(self, resource: str) -> str:
        path = resource.partition(";")[0]
        states = self._answers.told(path)
        return str(states[0].get(_classes(path)[1], ""))


def switching(response: HttpResponse) -> bytes:
    """Return the bytes by which HTTP ends on a connection and WebSocket begins."""
    lines = ["HTTP/1.1 101 Switching Protocols", *(f"{name}: {value}" for name, value in response.headers)]
    return "\r\n".join([*lines, "", ""]).encode()


def text_frame(text: str) -> bytes:
    """Return a whole text of a server."""
    data = text.encode()
    if len(data) <= _SHORT:
        return bytes([_TEXT_FRAME, len(data)]) + data
    return bytes([_TEXT_FRAME, _LENGTH_16]) + len(data).to_bytes(2, "big") + data


def _event(resource: str, value: str) -> str:
    event, name = _classes(resource.partition(";")[0])
    link = f'<a href="{resource}" rel="self"></a>'
    return f'<li class="{event}" title="{name}">{link}<span class="{name}">{value}</span></li>'


def _classes(path: str) -> tuple[str, str]:
    found = next((classes for begin, classes in _CLASSES.items() if path.startswith(begin)), None)
    if found is None:
        raise NotFoundError(f"{path} cannot be subscribed to")
    return found
