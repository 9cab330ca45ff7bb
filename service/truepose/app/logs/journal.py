"""The service writes its log through a queue: no line waits for a disk, and a full disk harms nothing.

A line that finds the queue full, or that the disk refuses, is counted and dropped. How many those were is
said before the next line that can be written.
"""

import contextlib
import glob
import logging
import queue
import sys
from collections.abc import Iterator
from io import TextIOWrapper
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path
from typing import Final, TextIO

from truepose.app.logs.few_repeats import FewRepeats
from truepose.app.logs.lines import REQUEST as REQUEST_FIELD
from truepose.app.logs.lines import JsonLines, Readable
from truepose.correlation import REQUEST
from truepose.storage.files.owner_alone import opened_alone, tighten
from truepose.web.observation.requests import LOGGER as REQUESTS

_WAITING: Final = 10_000  # lines
_FILE_BYTES: Final = 8 * 2**20
_FILES: Final = 5  # before the one that is written
_LOG: Final = logging.getLogger(__name__)


class Lost:
    """How many lines were not written."""

    def __init__(self) -> None:
        self.lines = 0


class _Queued(QueueHandler):
    """Hands a line over as it is now, with the request that led to it."""

    def __init__(self, waiting: "queue.Queue[logging.LogRecord]", lost: Lost) -> None:
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

    def __init__(self, file: Path, lost: Lost) -> None:
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
def logged(file: Path, level: str) -> Iterator[Lost]:
    """Write what is logged within the context; yields how many lines are lost."""
    lost = Lost()
    with contextlib.suppress(OSError):  # then every line is counted as lost
        file.parent.mkdir(parents=True, exist_ok=True)
        tighten(*file.parent.glob(f"{glob.escape(file.name)}.[0-9]"))  # of an older version, perhaps
    handlers = (_StandardError(), _File(file, lost))
    waiting: queue.Queue[logging.LogRecord] = queue.Queue(_WAITING)
    queued = _Queued(waiting, lost)
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
