"""Streams of events, as the document shows them: the schema is that of one event."""

from typing import Any, Final

EVENT_STREAM: Final = "text/event-stream"
_EVENT: Final = {
    "type": "object",
    "description": "One event of the stream.",
    "required": ["data"],
    "properties": {
        "id": {"description": "Its number, where it has one."},
        "event": {"type": "string", "description": "Of what kind it is."},
        "data": {"type": "string", "description": "What it says, as JSON."},
    },
}


def stream_content(example: str) -> dict[str, Any]:
    """Return what documents the answer of a stream."""
    return {EVENT_STREAM: {"schema": _EVENT, "example": example}}
