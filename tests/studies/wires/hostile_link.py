"""A wire in memory that does to what a device says what bad lines, slow peers and foreign hands do.

Time is virtual: whoever waits on it in vain is told at once. `Stall` takes as long as it says, so a reader
that waits longer hears what comes behind it.
"""

from collections import deque
from dataclasses import dataclass

from truepose_drivers.errors import ConnectionLostError

STALL_S = 0.05  # longer than any gap by which a driver might tell the end of a reply


@dataclass
class Stall:
    left_s: float = STALL_S


class Silence:
    """Nothing comes any more before somebody asks again."""


class HangUp:
    """The device closes the connection."""


class HostileLink:
    """Speaks for a device: `answer(data)` gives what it says, `spoil(pieces)` what becomes of it.

    A wire that `remembers` delivers late pieces after it was opened anew, as a terminal server does.
    """

    address = "the wire"

    def __init__(self, answer, *, by_itself=None, remembers=False):
        self.answer = answer
        self.by_itself = by_itself  # what a device says that is only listened to
        self.remembers = remembers
        self.spoil = None  # armed for one answer
        self.pieces = deque()
        self.late = deque()
        self.is_open = False

    async def open(self):
        self.is_open = True
        self.pieces.clear()
        if not self.remembers:
            self.late.clear()

    async def close(self):
        self.is_open = False

    async def send(self, data):
        self._require_open()
        said = self._spoiled(self.answer(data))
        self.pieces.extend(self.late)  # what was late comes when nobody drains any more
        self.late.clear()
        self.pieces.extend(said)

    async def receive(self, timeout_s):
        self._require_open()
        if not self.pieces and self.by_itself is not None and timeout_s > 0.0:
            self.pieces.extend(self._spoiled(self.by_itself()))
        while self.pieces:
            piece = self.pieces[0]
            if isinstance(piece, bytes):
                return self.pieces.popleft()
            if isinstance(piece, HangUp):
                await self.close()
                raise ConnectionLostError("the connection to the wire is gone: check it")
            if isinstance(piece, Silence) or piece.left_s > timeout_s:
                if isinstance(piece, Stall):
                    piece.left_s -= timeout_s
                else:
                    self.pieces.popleft()
                    self.late.extend(self.pieces)
                    self.pieces.clear()
                return None
            self.pieces.popleft()
        return None

    def _spoiled(self, said):
        spoil, self.spoil = self.spoil, None
        return said if spoil is None or not said else spoil(said)

    def _require_open(self):
        if not self.is_open:
            raise ConnectionLostError("there is no connection to the wire: connect first")


class HostileUsb:
    """The same for a USB device: packets of an interrupt endpoint, and reports of a HID device."""

    address = "the plug"

    def __init__(self, link, packet_bytes=8):
        self.link = link
        self._packet_bytes = packet_bytes

    @property
    def is_open(self):
        return self.link.is_open

    async def open(self):
        await self.link.open()

    async def close(self):
        await self.link.close()

    async def texts(self):
        return "maker", "thing", "SN-1"

    async def control_out(self, request_type, request, value=0, index=0, data=b""):
        if data:
            await self.link.send(data)

    async def control_in(self, request_type, request, value, index, length):
        return b"\x01"

    async def receive(self, timeout_s):
        piece = await self.link.receive(timeout_s)
        if piece is not None and len(piece) > self._packet_bytes:
            self.link.pieces.appendleft(piece[self._packet_bytes :])
            piece = piece[: self._packet_bytes]
        return piece
