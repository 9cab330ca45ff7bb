"""When a button was pressed: a network may deliver a tap minutes later, and an old one must move nothing."""

import time
from typing import Annotated, Final

from pydantic import Field

TIME_HEADER: Final = b"truepose-time"
PressedAt = Annotated[
    float | None,
    Field(
        ge=0,
        description="When it was pressed: the `Truepose-Time` of the service's newest answer, and what has "
        "passed since. Where it was under way for more than 3 s it lets nothing move. Null: just now.",
        examples=[81234.5],
    ),
]


def time_s() -> float:
    """Return the time that every answer tells; it does not go back while the machine runs."""
    return time.monotonic()


def under_way_s(pressed_at_s: float | None) -> float:
    """Return for how long a tap was under way; 0 where it does not say."""
    return 0.0 if pressed_at_s is None else time_s() - pressed_at_s
