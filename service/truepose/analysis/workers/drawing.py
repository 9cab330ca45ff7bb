"""A report drawn or printed in a worker process: it takes seconds of a processor."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class DrawTask:
    """Call a function of a module with one argument that can travel; its answer travels back."""

    draw: Callable[[Any], str | bytes]
    of: object

    def perform(self, report: Callable[[float, str], None]) -> str | bytes:
        """Return what is drawn; raises TrueposeError."""
        report(0.0, "drawing")
        return self.draw(self.of)
