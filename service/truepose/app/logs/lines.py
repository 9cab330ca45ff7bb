"""How a line of the log reads: as JSON for programs, as a sentence for people."""

import json
import logging
from datetime import UTC, datetime
from typing import Any, Final

FIELDS: Final = "fields"  # name under which a caller hands over values of its own: `extra={"fields": {...}}`
REQUEST: Final = "request"


class JsonLines(logging.Formatter):
    """One JSON object a line: `time, level, logger, message`, and what else is known of it."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a line without its end."""
        told: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request": getattr(record, REQUEST, None),
            **getattr(record, FIELDS, {}),
        }
        if record.exc_text:
            told["traceback"] = record.exc_text
        return json.dumps(told, ensure_ascii=False, default=str)


class Readable(logging.Formatter):
    """Level, origin and sentence; the request where one led to it."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a line, and the traceback below it where there is one."""
        request = getattr(record, REQUEST, None)
        because = "" if request is None else f" [{request}]"
        line = f"{record.levelname} {record.name}: {record.getMessage()}{because}"
        return f"{line}\n{record.exc_text}" if record.exc_text else line
