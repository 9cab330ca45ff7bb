"""How a process of this program begins and ends: without searches that find nothing."""

import gc
import os
from typing import Final

# Importing makes a hundred thousand objects and hardly a cycle; by default they are searched at every 700.
_OBJECTS_BETWEEN_SEARCHES: Final = 500_000


def begin_lightly() -> None:
    """Search for garbage seldom and for plug-ins never; to be called before anything large is loaded."""
    gc.set_threshold(_OBJECTS_BETWEEN_SEARCHES)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # to find none takes a look at every package


def end_lightly() -> None:
    """Spare the interpreter, which is about to end, a last search through every module."""
    gc.freeze()
