"""What a driver needs of a connection: bytes with time-outs in wall time, and the two ways it ends."""

from typing import Final, Protocol

from truepose_drivers.errors import RemoteProtocolError

_MOST_PIECES: Final = 10_000  # waiting on a stream: whoever sends more never stops


class Link(Protocol):
    """A byte stream to one device; can be opened again after it was lost."""

    @property
    def address(self) -> str:
        """Where the device is, for error texts."""
        ...

    @property
    def is_open(self) -> bool:
        """Whether the stream is up as far as known."""
        ...

    async def open(self) -> None:
        """Connect, dropping what was open before; raises ConnectFailedError."""
        ...

    async def send(self, data: bytes) -> None:
        """Hand `data` to the stream; raises ConnectionLostError."""
        ...

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, at least one byte; None after `timeout_s` [s, wall time] of silence.

        With a time-out of 0 only what is there already. Raises ConnectionLostError at the stream's end.
        """
        ...

    async def close(self) -> None:
        """Close the stream; never raises."""
        ...


async def drain(link: Link) -> None:
    """Drop what arrived unasked, so that it is not taken for the answer to the next question.

    Raises RemoteProtocolError where it does not end.
    """
    for _ in range(_MOST_PIECES):
        if await link.receive(0.0) is None:
            return
    raise RemoteProtocolError(
        f"whoever is at {link.address} does not stop sending: is this the right address?"
    )
