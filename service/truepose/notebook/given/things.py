"""What a function is given: the thing that it works on, or the file or folder that this is read from."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias, TypeVar

from truepose.domain.errors import ConfigurationError

T = TypeVar("T")
Progress: TypeAlias = Callable[[float, str], None]


def read_if_path(given: T | str | Path, kind: type[T], read: Callable[[str | Path], T], advice: str) -> T:
    """Return what is given, read first where it is a path.

    Raises
    ------
    ConfigurationError
        It is neither; the sentence says what is given and ends with `advice`.
    """
    if isinstance(given, str | Path):
        return read(given)
    if isinstance(given, kind):
        return given
    raise ConfigurationError(_refusal(given, kind.__name__.lower(), advice))


def path_of(given: str | Path, what: str, advice: str) -> Path:
    """Return a path; raises ConfigurationError where what is given names no file."""
    if isinstance(given, str | Path):
        return Path(given)
    raise ConfigurationError(_refusal(given, what, advice))


def effects_given(given: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the names of effects; a single one may stand without a list."""
    return (given,) if isinstance(given, str) else None if given is None else tuple(given)


def _refusal(given: object, what: str, advice: str) -> str:
    name = type(given).__name__
    return f"{'An' if name[0] in 'AEIOUaeiou' else 'A'} {name} is no {what}: {advice}."
