"""The cell file of a cell that stands in this process."""

from collections.abc import Sequence

from truepose_simulators.instruments.endpoint import Address

_DRIVERS = {
    "open_abb": "abb_open_abb",
    "nd28x": "heidenhain_nd",
    "hid": "ballbar_hid",
    "hands": "cell_hands",
    "clock": "cell_clock",
}
_ROBOTS = {"irb120": "abb-irb-120", "lrmate": "fanuc-lr-mate-200ic"}


def cell_text(scenario: str, addresses: Sequence[Address], limits: str = "") -> str:
    """Return the text of a cell file; `limits` is its [limits] section."""
    robot = next(name for prefix, name in _ROBOTS.items() if scenario.startswith(prefix))
    heading = f'robot = "{robot}"\n[ballbar]\nbase_points = 3\n'
    return "\n".join([heading, limits, *(_device(found) for found in addresses)])


def _device(found: Address) -> str:
    named = f'[[device]]\nname = "{found.device}"\ndriver = "{_DRIVERS[found.protocol]}"'
    return f'{named}\nhost = "{found.host}"\nport = {found.port}'
