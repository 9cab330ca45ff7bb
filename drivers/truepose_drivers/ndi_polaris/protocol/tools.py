"""Port handles, and the tool definitions that are loaded into them."""

import re
from collections.abc import Iterator, Sequence

from truepose_drivers.ndi_polaris.protocol.replies import NdiProtocolError, Text
from truepose_drivers.ndi_polaris.protocol.requests import Request

ANY_PASSIVE_TOOL = Request("PHRQ", "*********1****")  # arguments: hardware, system, type, port, all left open
PAGE_BYTES = 64
LARGEST_DEFINITION = 1_024  # bytes of a .rom file

_HANDLE = re.compile(r"[0-9A-F]{2}")
_HANDLES = re.compile(r"([0-9A-F]{2})((?:[0-9A-F]{5})*)")
_ENTRY = re.compile(r"([0-9A-F]{2})([0-9A-F]{3})")


def page_writes(handle: int, definition: bytes) -> Iterator[Request]:
    """Yield the writes that load a definition, which is filled up with zeros to its largest size."""
    image = definition.ljust(LARGEST_DEFINITION, b"\0")
    for address in range(0, LARGEST_DEFINITION, PAGE_BYTES):
        page = image[address : address + PAGE_BYTES].hex().upper()
        yield Request("PVWR", f"{handle:02X}{address:04X}{page}")


def decode_handle(reply: Text) -> int:
    """Read the answer to PHRQ; raises NdiProtocolError."""
    if not _HANDLE.fullmatch(reply.text):
        raise NdiProtocolError(f"the camera answered {reply.text[:40]!r} where a port handle was expected")
    return int(reply.text, 16)


def encode_handles(handles: Sequence[tuple[int, int]]) -> Text:
    """Return the answer to PHSR: handles and the low twelve bits of their status."""
    return Text(
        f"{len(handles):02X}" + "".join(f"{handle:02X}{status & 0xFFF:03X}" for handle, status in handles)
    )


def decode_handles(reply: Text) -> list[tuple[int, int]]:
    """Read the answer to PHSR: handles and status; raises NdiProtocolError."""
    found = _HANDLES.fullmatch(reply.text)
    entries = _ENTRY.findall(found[2]) if found else []
    if found is None or len(entries) != int(found[1], 16):
        raise NdiProtocolError(
            f"the camera answered {reply.text[:40]!r} where a list of handles was expected"
        )
    return [(int(handle, 16), int(status, 16)) for handle, status in entries]
