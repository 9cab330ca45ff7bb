"""What a codec's reader makes of a stream that comes in pieces."""


def messages_in(reader, data: bytes, chunk: int = 4096) -> list[object]:
    """Return the messages that a reader takes from `data`, given to it `chunk` bytes at a time."""
    found = []
    for start in range(0, len(data), chunk):
        reader.receive_data(data[start : start + chunk])
        while (message := reader.next_message()) is not None:
            found.append(message)
    return found
