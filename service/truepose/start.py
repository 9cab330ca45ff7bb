"""How a process of this program begins and ends: one thread, and no searches that find nothing."""

import gc
import io
import os
import sys
from typing import Final

# Importing makes a hundred thousand objects and hardly a cycle; by default they are searched at every 700.
_OBJECTS_BETWEEN_SEARCHES: Final = 500_000

# A library of linear algebra adds in an order that depends on the number of its threads, so that the last
# bits of a result would follow from the computer and the shell. Of matrices as small as ours several threads
# make nothing quicker (decision 0070).
ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"
)


def begin_lightly() -> None:
    """Compute with one thread, search for garbage seldom and for plug-ins never.

    To be called before anything large is loaded. Processes that this one starts compute with one thread, too.
    """
    os.environ.update(ONE_THREAD)
    gc.set_threshold(_OBJECTS_BETWEEN_SEARCHES)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # to find none takes a look at every package


def speak_unicode() -> None:
    """Say whatever a language asks for: as UTF-8 on Windows, as the computer is set up elsewhere.

    What that set-up has no character for is written as its number.
    """
    encoding = "utf-8" if sys.platform == "win32" else None
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding=encoding, errors="backslashreplace")


def end_lightly() -> None:
    """Spare the interpreter, which is about to end, a last search through every module."""
    gc.freeze()
