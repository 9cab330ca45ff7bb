"""Idempotency-Keys: a request that is sent again gets the record that its first sending made."""

from collections.abc import Callable

from sqlalchemy import Connection, select

from truepose.storage.errors import KeyReusedError
from truepose.storage.records import RequestKey
from truepose.storage.rows import add_row
from truepose.storage.tables import request_keys


def once(
    connection: Connection, key: RequestKey | None, resource: str, create: Callable[[Connection], int]
) -> int:
    """Return the number that `create` gives, or gave when `key` was first seen; one transaction.

    Raises KeyReusedError where the key came with another request before.
    """
    known = None if key is None else answered(connection, key, resource)
    if known is not None:
        return known
    number = create(connection)
    if key is not None:
        add_row(
            connection,
            request_keys,
            key=key.key,
            fingerprint=key.fingerprint,
            resource=resource,
            resource_id=number,
        )
    return number


def answered(connection: Connection, key: RequestKey, resource: str) -> int | None:
    """Return the number that a request with this key got, None where it is new; raises KeyReusedError."""
    query = select(request_keys).where(request_keys.c.key == key.key)
    known = connection.execute(query).one_or_none()
    if known is None:
        return None
    if (known.fingerprint, known.resource) != (key.fingerprint, resource):
        raise KeyReusedError(
            f"The Idempotency-Key '{key.key}' was used for another request; take a new key for a new request."
        )
    return int(known.resource_id)
