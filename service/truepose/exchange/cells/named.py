"""Entries of a cell file that have names of their own."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from truepose.exchange.document import Node


class _Named(Protocol):
    @property
    def name(self) -> str: ...


N = TypeVar("N", bound=_Named)


def read_by_name(node: Node, read: Callable[[Node], N], called: str) -> dict[str, N]:
    """Read the entries of a list, by name; raises InputFileError where two are called the same."""
    found: dict[str, N] = {}
    for entry in node.items():
        one = read(entry)
        if one.name in found:
            entry.key("name").fail(f"two {called} are called {one.name!r}; names must differ")
        found[one.name] = one
    return found
