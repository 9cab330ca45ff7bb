"""A USB device on a wire of a bench: packets of an interrupt endpoint, and reports of a HID device."""

from truepose_drivers.errors import ConnectionLostError


class UsbPlug:
    address = "the plug"

    def __init__(self, wiring, wire, bench, packet_bytes=8):
        self._wiring = wiring
        self.wire = wire
        self._bench = bench
        self._packet_bytes = packet_bytes
        self._rest = b""

    @property
    def is_open(self):
        return self.wire.is_open

    async def open(self):
        self._rest = b""
        await self.wire.open()

    async def close(self):
        await self.wire.close()

    async def texts(self):
        await self.require_there()
        return "maker", "thing", self._bench.serial

    async def require_there(self):
        """See that control requests get through."""
        if self.is_open and not self._wiring.deaf:
            return
        await self.close()
        raise ConnectionLostError("not connected to the plug: check its cable, then connect first")

    async def control_out(self, request_type, request, value=0, index=0, data=b""):
        await self.require_there()
        if data:
            await self.wire.send(data)

    async def control_in(self, request_type, request, value, index, length):
        await self.require_there()
        return b"\x01"

    async def receive(self, timeout_s):
        if not self._rest:
            self._rest = await self.wire.receive(timeout_s) or b""
        packet, self._rest = self._rest[: self._packet_bytes], self._rest[self._packet_bytes :]
        return packet or None
