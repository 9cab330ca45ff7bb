"""Which operation a request asks for, before anything of it is read."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from fastapi.responses import HTMLResponse

from truepose.web.requests.by_path import ByPath


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


def asked_operation(operations: ByPath[Operation], method: str, path: str) -> Operation | None:
    """Return what is asked for; None where there is no such thing."""
    return next((o for o in operations.at(path) if method in o.methods and o.matches.match(path)), None)
