"""Wire protocol of NDI's optical trackers (combined API of Polaris and Vega): bytes in, messages out.

Source: NDI's public API guide of the Polaris Vega as the open client `PlusToolkit/ndicapi` (MIT) speaks it.
A request is answered once; nothing comes unasked but RESET. Millimetres, quaternions q0 qx qy qz.
"""

from truepose_drivers.ndi_polaris.protocol.checksum import crc16
from truepose_drivers.ndi_polaris.protocol.facts import Identified, facts, identified
from truepose_drivers.ndi_polaris.protocol.replies import (
    OKAY,
    RESET,
    Binary,
    NdiProtocolError,
    Reply,
    ReplyReader,
    Text,
    encode_reply,
    error_code,
    error_text,
)
from truepose_drivers.ndi_polaris.protocol.requests import Damaged, Request, RequestReader, encode_request
from truepose_drivers.ndi_polaris.protocol.tools import (
    ANY_PASSIVE_TOOL,
    LARGEST_DEFINITION,
    PAGE_BYTES,
    decode_handle,
    decode_handles,
    encode_handles,
    page_writes,
)
from truepose_drivers.ndi_polaris.protocol.tracking import (
    PortStatus,
    ToolFrame,
    ToolPose,
    decode_binary,
    decode_text,
    encode_binary,
    encode_text,
)

DEFAULT_PORT = 8765

__all__ = [
    "ANY_PASSIVE_TOOL",
    "DEFAULT_PORT",
    "LARGEST_DEFINITION",
    "OKAY",
    "PAGE_BYTES",
    "RESET",
    "Binary",
    "Damaged",
    "Identified",
    "NdiProtocolError",
    "PortStatus",
    "Reply",
    "ReplyReader",
    "Request",
    "RequestReader",
    "Text",
    "ToolFrame",
    "ToolPose",
    "crc16",
    "decode_binary",
    "decode_handle",
    "decode_handles",
    "decode_text",
    "encode_binary",
    "encode_handles",
    "encode_reply",
    "encode_request",
    "encode_text",
    "error_code",
    "error_text",
    "facts",
    "identified",
    "page_writes",
]
