"""Which route and operation a path asks for, by its first words: there are too many to try each."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from fastapi.responses import HTMLResponse
from starlette.routing import BaseRoute, Match
from starlette.types import ASGIApp, Receive, Scope, Send

T = TypeVar("T")
_API: Final = "/api/v1/"


class RouteTable(Generic[T]):
    """Things that each have a path, with parameters in braces, in the order in which they count."""

    def __init__(self, things: Iterable[tuple[str, T]]) -> None:
        self._anywhere: list[T] = []  # begins with a parameter
        self._at: dict[str, list[T]] = {}
        for path, thing in things:
            word = _first_word(path)
            if "{" in word:
                self._anywhere.append(thing)
                for found in self._at.values():
                    found.append(thing)
            else:
                self._at.setdefault(word, [*self._anywhere]).append(thing)

    def at(self, path: str) -> Sequence[T]:
        """Return what may be at a path, in their order."""
        return self._at.get(_first_word(path), self._anywhere)


def _first_word(path: str) -> str:
    """Return what tells one resource, or one page, from the others."""
    begin = len(_API) if path.startswith(_API) else 1
    return path[: begin + len(path[begin:].partition("/")[0])]


class Routing:
    """Middleware of a router: answers by the route at the path, and leaves to the router what has none."""

    def __init__(self, router: ASGIApp, routes: Sequence[BaseRoute]) -> None:
        self._router = router
        self._routes = RouteTable((getattr(route, "path", "/{any}"), route) for route in routes)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        for route in self._routes.at(scope["path"]) if scope["type"] == "http" else ():
            match, found = route.matches(scope)
            if match is Match.FULL:
                scope.update(found)
                await route.handle(scope, receive, send)
                return
        await self._router(scope, receive, send)


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation and where it is asked for."""

    name: str
    path: str  # with its parameters in braces
    methods: frozenset[str]
    is_page: bool
    matches: re.Pattern[str]


def operations_of(routes: Iterable[Any]) -> tuple[Operation, ...]:
    """Return every operation, in the order in which the router looks at them."""
    return tuple(
        Operation(
            route.name,
            route.path,
            frozenset(route.methods or ()),
            getattr(route, "response_class", None) is HTMLResponse,
            route.path_regex,
        )
        for route in routes
    )


def requested_operation(operations: RouteTable[Operation], method: str, path: str) -> Operation | None:
    """Return what is asked for; None where there is no such thing."""
    # By the router's own patterns, in its order: what is judged has to be what will be answered.
    return next((o for o in operations.at(path) if method in o.methods and o.matches.match(path)), None)
