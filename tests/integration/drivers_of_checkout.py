"""The drivers of this checkout, whether it is installed or not."""

import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

from truepose_drivers.registry import ENTRY_POINT_GROUP, load_registry

_PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def drivers_of_checkout():
    registered = tomllib.loads(_PYPROJECT.read_text())["project"]["entry-points"][ENTRY_POINT_GROUP]
    return load_registry([EntryPoint(name, value, ENTRY_POINT_GROUP) for name, value in registered.items()])
