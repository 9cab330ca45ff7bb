"""Requests that are being answered: one that is repeated meanwhile waits for the same answer."""

import asyncio
from collections.abc import Callable, Coroutine, Hashable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from truepose.messages.message import message
from truepose.storage.errors import KeyReusedError
from truepose.storage.records import RequestKey

T = TypeVar("T")


@dataclass(slots=True)
class _UnderWay(Generic[T]):
    fingerprint: str
    task: asyncio.Task[T]
    waiting: int = 0
    ending: asyncio.TimerHandle | None = None


class RequestsUnderWay(Generic[T]):
    """Runs each once; not cancelled with its request, so that a tablet that vanished finds its answer.

    With `kept_s` the work of a request for which nobody has waited so long is cancelled after all.
    """

    def __init__(self, kept_s: float | None = None) -> None:
        self._kept_s = kept_s
        self._under_way: dict[Hashable, _UnderWay[T]] = {}

    async def shared(
        self, name: Hashable, key: RequestKey, answer: Callable[[], Coroutine[Any, Any, T]]
    ) -> T:
        """Return what `answer` returns; raises KeyReusedError for another request under the same name."""
        found = self._under_way.get(name)
        if found is None:
            task = asyncio.create_task(answer())
            # Entered before anything is awaited: of two equal requests the second finds the first.
            found = self._under_way[name] = _UnderWay(key.fingerprint, task)
            task.add_done_callback(lambda _: self._forget(name, task))
        elif found.fingerprint != key.fingerprint:
            raise KeyReusedError(message("session.refused.key_of_another_act", key=key.key))
        return await self._awaited(name, found)

    async def _awaited(self, name: Hashable, found: _UnderWay[T]) -> T:
        found.waiting += 1
        # Somebody asks again in time.
        if found.ending is not None:
            found.ending.cancel()
            found.ending = None
        try:
            # A tablet that loses its network ends its request; what it asked for goes on, and its next
            # request finds the answer.
            return await asyncio.shield(found.task)
        finally:
            found.waiting -= 1
            if found.waiting == 0 and self._kept_s is not None:
                loop = asyncio.get_running_loop()
                found.ending = loop.call_later(self._kept_s, self._end, name, found.task)

    def _end(self, name: Hashable, task: asyncio.Task[T]) -> None:
        self._forget(name, task)  # at once: whoever asks now begins anew
        task.cancel()  # one that has ended takes no harm from it

    def _forget(self, name: Hashable, task: asyncio.Task[T]) -> None:
        found = self._under_way.get(name)
        # Another request may have begun anew under this name.
        if found is not None and found.task is task:
            del self._under_way[name]
