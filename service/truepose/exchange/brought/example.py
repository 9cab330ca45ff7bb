"""The example that a newcomer without readings begins with; its files lie beside this one."""

from importlib.resources import files
from typing import Final

_NAMES: Final = ("campaign.json", "left arm.csv", "left arm check.csv")


def example_files() -> dict[str, bytes]:
    """Return its files by name: readings of a simulated robot, as it says of itself."""
    folder = files("truepose.exchange.brought") / "example"
    return {name: (folder / name).read_bytes() for name in _NAMES}
