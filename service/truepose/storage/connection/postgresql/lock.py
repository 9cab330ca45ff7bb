"""The lock that keeps a second service off a database of a server.

The connection that writes holds it itself: as long as that connection lives nobody else has the lock, and
with the connection goes the lock. So no commit is ever acknowledged by a service that has lost it. And who
gets the lock back after a connection ended knows that the server has done with the one before, and with its
last transaction.
"""

import time
from typing import Any, Final

from truepose.storage.errors import DatabaseInUseError

_OURS: Final = 0x74_70_73_65  # among the locks that other programs take in the same database
_TRY: Final = "SELECT pg_try_advisory_lock(?, hashtext(current_schema()))"
_PATIENCE_S: Final = 2.0  # until the server has noticed that a service was killed
_AGAIN_S: Final = 0.05


def take_lock(connection: Any, where: str, patience_s: float = _PATIENCE_S) -> None:
    """Take the lock for as long as a plain connection lives; raises DatabaseInUseError."""
    until_s = time.monotonic() + patience_s
    while not connection.execute(_TRY, (_OURS,)).fetchone()[0]:
        if time.monotonic() > until_s:
            raise DatabaseInUseError(
                f"The database {where} is in use by another truepose service; "
                "stop that one, or choose another database with --database."
            )
        time.sleep(_AGAIN_S)
