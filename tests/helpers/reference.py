"""Numbers of others, from `tests/reference`."""

import tomllib
from typing import Any

from tests.helpers.checkout import CHECKOUT


def reference(name: str) -> dict[str, Any]:
    """Return the numbers of a file; its head says where they come from."""
    path = CHECKOUT / "tests" / "reference" / f"{name}.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))
