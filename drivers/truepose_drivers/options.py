"""Reading the options of a cell file; every complaint names the option and what belongs there."""

import math

from truepose_drivers.api import Options, Vector
from truepose_drivers.errors import ConfigurationError

_HIGHEST_PORT = 65_535


def host(options: Options) -> str:
    """Return option `host`; raises ConfigurationError when it is missing or no text."""
    value = options.get("host")
    if not isinstance(value, str) or not value.strip():
        raise ConfigurationError(f"option host is {value!r}: give the device's address, such as 192.168.0.1")
    return value


def port(options: Options, default: int | None = None, *, name: str = "port") -> int:
    """Return a port; raises ConfigurationError when it is missing or no port number."""
    value = options.get(name, default)
    # Python's True is an int, and `port = true` in a cell file would open port 1.
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= _HIGHEST_PORT:
        raise ConfigurationError(f"option {name} is {value!r}: give a number from 1 to {_HIGHEST_PORT}")
    return value


def text(options: Options, name: str) -> str | None:
    """Return an optional text; raises ConfigurationError when it is something else."""
    value = options.get(name)
    if value is not None and (not isinstance(value, str) or not value.strip()):
        raise ConfigurationError(f"option {name} is {value!r}: give a text, or leave it out")
    return value


def positive(options: Options, name: str, default: float) -> float:
    """Return a positive number; raises ConfigurationError when it is something else."""
    value = options.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise ConfigurationError(f"option {name} is {value!r}: give a positive number")
    return float(value)


def vector(options: Options, name: str) -> Vector:
    """Return three numbers in a text, 0 0 0 where there is none; raises ConfigurationError."""
    words = str(options.get(name, "0 0 0")).split()
    try:
        x, y, z = map(float, words)
    except ValueError:
        # One complaint for words that are no numbers, for two or four of them, and for nan: it shows an
        # example.
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        raise ConfigurationError(
            f'option {name} is {options.get(name)!r}: give three numbers, as in "0 0 125"'
        )
    return x, y, z
