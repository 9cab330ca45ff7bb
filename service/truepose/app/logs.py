"""The log of the service: lines for people and for programs, few repeats, a file that stays small.

A line that finds the queue full, or that the disk refuses, is counted and dropped. How many those were is
said before the next line that can be written.
"""

import contextlib
import glob
import json
import logging
import queue
import sys
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from io import TextIOWrapper
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path
from typing import Any, Final, TextIO

from truepose.correlation import REQUEST
from truepose.storage.engine.files import opened_alone, tighten
from truepose.web.middleware.request_log import LOGGER as REQUESTS

_BURST: Final = 5
_WINDOW_S: Final = 10.0
_MOST_KEYS: Final = 1000
# What these write, strangers cause, each time with other addresses and numbers in it.
_OF_STRANGERS: Final = ("uvicorn", "asyncio", REQUESTS)
_MOST_REQUESTS: Final = 500  # of each level; what a shop with fifty tablets asks in that time


class FewRepeats(logging.Filter):
    """Lets a few lines of a kind through in ten seconds; the next one after that says how many there were."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._seen: dict[tuple[str, int, str], tuple[float, int]] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a line is written; adds to it how many were not."""
        text = "" if record.name.startswith(_OF_STRANGERS) else record.getMessage()
        key = (record.name, record.levelno, text)
        now_s = self._clock()
        burst = _MOST_REQUESTS if record.name == REQUESTS else _BURST
        began_s, count = self._seen.get(key, (now_s, 0))
        if now_s - began_s >= _WINDOW_S:
            if count > burst:
                record.msg = f"{record.getMessage()} (and {count - burst} similar lines, not written)"
                record.args = ()
            began_s, count = now_s, 0
        if len(self._seen) >= _MOST_KEYS:
            self._seen.clear()
        self._seen[key] = (began_s, count + 1)
        return count < burst


FIELDS: Final = "fields"  # name under which a caller hands over values of its own: `extra={"fields": {...}}`
REQUEST_FIELD: Final = "request"


class JsonLines(logging.Formatter):
    """One JSON object a line: `time, level, logger, message`, and what else is known of it."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a line without its end."""
        told: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "request": getattr(record, REQUEST_FIELD, None),
            **getattr(record, FIELDS, {}),
        }
        if record.exc_text:
            told["traceback"] = record.exc_text
        return json.dumps(told, ensure_ascii=False, default=str)


class Readable(logging.Formatter):
    """Level, origin and sentence; the request where one led to it."""

    def format(self, record: logging.LogRecord) -> str:
        """Return a line, and the traceback below it where there is one."""
        request = getattr(record, REQUEST_FIELD, None)
        because = "" if request is None else f" [{request}]"
        line = f"{record.levelname} {record.name}: {record.getMessage()}{because}"
        return f"{line}\n{record.exc_text}" if record.exc_text else line


_WAITING: Final = 10_000  # lines
_FILE_BYTES: Final = 8 * 2**20
_FILES: Final = 5  # before the one that is written
_LOG: Final = logging.getLogger(__name__)


class DroppedLines:
    """How many lines were not written."""

    def __init__(self) -> None:
        self.lines = 0


class _QueueHandler(QueueHandler):
    """Hands a line over as it is now, with the request that led to it."""

    def __init__(self, waiting: "queue.Queue[logging.LogRecord]", lost: DroppedLines) -> None:
        super().__init__(waiting)
        self._lost = lost

    def prepare(self, record: logging.LogRecord) -> logging.LogRecord:
        record.msg, record.args = record.getMessage(), None
        if record.exc_info:
            record.exc_text = logging.Formatter().formatException(record.exc_info)
            record.exc_info = None
        setattr(record, REQUEST_FIELD, REQUEST.get())
        return record

    def enqueue(self, record: logging.LogRecord) -> None:
        try:
            self.queue.put_nowait(record)
        except queue.Full:
            self._lost.lines += 1


class _File(RotatingFileHandler):
    """Lines of JSON; what the disk refuses is counted."""

    def __init__(self, file: Path, lost: DroppedLines) -> None:
        super().__init__(file, maxBytes=_FILE_BYTES, backupCount=_FILES, encoding="utf-8", delay=True)
        self.setFormatter(JsonLines())
        self._lost = lost
        self._told = 0
        self._failed = False

    def _open(self) -> TextIOWrapper:
        return open(self.baseFilename, "a", encoding="utf-8", opener=opened_alone)

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line, after one that says how many were lost."""
        if self._lost.lines > self._told:
            self._tell()
        if not self._failed:
            super().emit(record)
        if self._failed:
            self._lost.lines += 1
            self._failed = False

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 (the library's name)
        """Note that a line could not be written; the next one opens the file anew."""
        self._failed = True
        with contextlib.suppress(OSError, ValueError):
            self.close()

    def _tell(self) -> None:
        lost = self._lost.lines
        super().emit(_line(logging.WARNING, f"{lost - self._told} lines before this one were not written."))
        if not self._failed:
            self._told = lost


class _StandardError(logging.StreamHandler[TextIO]):
    """Readable lines; requests that were answered are told in the file alone."""

    def __init__(self) -> None:
        super().__init__(sys.stderr)
        self.setFormatter(Readable())
        self.addFilter(lambda record: record.name != REQUESTS or record.levelno >= logging.WARNING)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 (the library's name)
        """Let a line go that nobody reads any more."""


@contextlib.contextmanager
def logged(file: Path, level: str) -> Iterator[DroppedLines]:
    """Write what is logged within the context; yields how many lines are lost."""
    lost = DroppedLines()
    with contextlib.suppress(OSError):  # then every line is counted as lost
        file.parent.mkdir(parents=True, exist_ok=True)
        tighten(*file.parent.glob(f"{glob.escape(file.name)}.[0-9]"))  # somebody has opened them, perhaps
    handlers = (_StandardError(), _File(file, lost))
    waiting: queue.Queue[logging.LogRecord] = queue.Queue(_WAITING)
    queued = _QueueHandler(waiting, lost)
    queued.addFilter(FewRepeats())
    listener = QueueListener(waiting, *handlers)
    everything = logging.getLogger()
    before = everything.level
    everything.addHandler(queued)
    everything.setLevel(level)
    listener.start()
    try:
        yield lost
    finally:
        everything.removeHandler(queued)
        everything.setLevel(before)
        listener.stop()
        for handler in handlers:
            handler.close()


def _line(level: int, text: str) -> logging.LogRecord:
    return logging.LogRecord(_LOG.name, level, __file__, 0, text, None, None)
