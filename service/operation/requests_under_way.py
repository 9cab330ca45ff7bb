"""Requests that are being answered: one that is repeated meanwhile waits for the same answer."""

import asyncio
from collections.abc import Callable, Coroutine, Hashable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from service.storage.errors import KeyReusedError
from service.storage.records import RequestKey

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _UnderWay(Generic[T]):
    fingerprint: str
    task: asyncio.Task[T]


class RequestsUnderWay(Generic[T]):
    """Runs each once; not cancelled with its request, so that a tablet that vanished finds its answer."""

    def __init__(self) -> None:
        self._under_way: dict[Hashable, _UnderWay[T]] = {}

    async def shared(
        self, name: Hashable, key: RequestKey, answer: Callable[[], Coroutine[Any, Any, T]]
    ) -> T:
        """Return what `answer` returns; raises KeyReusedError for another request under the same name."""
        found = self._under_way.get(name)
        if found is None:
            task = asyncio.create_task(answer())
            found = self._under_way[name] = _UnderWay(key.fingerprint, task)
            task.add_done_callback(lambda _: self._under_way.pop(name, None))
        elif found.fingerprint != key.fingerprint:
            raise KeyReusedError(
                f"The Idempotency-Key '{key.key}' was used for another act; take a new key for a new act."
            )
        return await asyncio.shield(found.task)
