"""PINs that count no more, and those of a copy: their hashes are taken out, so that nobody tries all PINs.

A PIN has few digits, and whoever has its hash finds it. This is the one thing that is ever taken out of a
record: what is left opens nothing and says so, its link stays as it is, and whoever verifies passes it over.
"""

from collections.abc import Sequence
from typing import Any, Final

from truepose.storage.migrations.triggers import server_trigger, trigger, trigger_name

TAKEN_OUT: Final = "taken out"
PIN: Final = "pin"  # kind of a credential
_TABLE: Final = "credentials"
_LEFT: Final = f"FROM {_TABLE} WHERE kind = '{PIN}' AND hash <> '{TAKEN_OUT}'"
_REVOKED: Final = " AND id IN (SELECT credential_id FROM revocations)"


def take_out_pins(connection: Any, *, revoked_only: bool) -> int:
    """Take the hashes of PINs out of a database, within the caller's transaction; returns how many.

    `connection` is the library's own (`connection.plain`). Raises what the library raises.
    """
    these = _LEFT + (_REVOKED if revoked_only else "")
    count = int(connection.execute(f"SELECT count(*) {these}").fetchone()[0])
    if not count:
        return 0
    on_server = hasattr(connection, "server")
    of = f" ON {_TABLE}" if on_server else ""
    connection.execute(f"DROP TRIGGER {trigger_name(_TABLE, 'update')}{of}")
    chosen = f"(SELECT id {these})"
    connection.execute(f"UPDATE {_TABLE} SET hash = '{TAKEN_OUT}' WHERE id IN {chosen}")
    connection.execute((server_trigger if on_server else trigger)(_TABLE, "update"))
    return count


def is_taken_out(record: str, names: Sequence[str], values: Sequence[Any]) -> bool:
    """Whether a record is a PIN without its hash, which has no longer the hash of its link."""
    if record != _TABLE:
        return False
    found = dict(zip(names, values, strict=True))
    return _said(found["kind"]) == PIN.encode() and _said(found["hash"]) == TAKEN_OUT.encode()


def without_pin(record: str, names: Sequence[str], values: Sequence[Any]) -> Sequence[Any]:
    """Return the values of a record as they are written into a copy."""
    if record != _TABLE or values[names.index("kind")] != PIN:
        return values
    return [TAKEN_OUT if name == "hash" else value for name, value in zip(names, values, strict=True)]


def _said(value: Any) -> bytes:
    return value.encode() if isinstance(value, str) else bytes(value)
