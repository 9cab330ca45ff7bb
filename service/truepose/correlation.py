"""Which request led to what is done: one name that follows it through jobs, sessions and workers.

A task that is begun while a request is answered inherits it; so do the lines that it writes to the log.
"""

import random
import re
from contextvars import ContextVar
from typing import Final

REQUEST: Final[ContextVar[str | None]] = ContextVar("request", default=None)
_WELL_FORMED: Final = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._:-]{0,62}[A-Za-z0-9])?")
_BITS: Final = 64  # of a name that is drawn here
_NAMES: Final = random.Random()


def request_named(given: str | None) -> str:
    """Return the name that a client gave its request, a new one where it gave none that can be used."""
    if given is not None and _WELL_FORMED.fullmatch(given):
        return given
    return f"{_NAMES.getrandbits(_BITS):016x}"
