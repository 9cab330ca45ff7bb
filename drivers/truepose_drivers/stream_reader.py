"""What readers of all codecs begin with: bytes that wait until a message is whole."""


class StreamReader:
    """Collects what a stream delivers; a codec's reader takes its messages from there."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return bool(self._buffer)

    def receive_data(self, data: bytes) -> None:
        """Append what the stream delivered."""
        self._buffer += data

    def _take(self, length: int, *, drop: int = 0) -> bytes:
        """Return the oldest `length` bytes, and drop those that only end them."""
        taken = bytes(self._buffer[:length])
        del self._buffer[: length + drop]
        return taken
