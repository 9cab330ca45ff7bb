"""What `--workers` says, read and refused before anything large is loaded."""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Final

from truepose.domain.errors import ConfigurationError

_SCHEME: Final = "dask://"
_MOST: Final = 1024  # processes
_LAST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class Named:
    """So many processes, a scheduler, or Dask on this computer."""

    processes: int = 0
    scheduler: str = ""  # host:port

    @property
    def host_and_port(self) -> tuple[str, int]:
        """Of the scheduler."""
        host, _, port = self.scheduler.rpartition(":")
        return host.strip("[]"), int(port)


def named(where: str) -> Named:
    """Return what is meant; raises ConfigurationError for what cannot be, and where Dask is not installed."""
    if where.startswith(_SCHEME):
        address = where.removeprefix(_SCHEME).rstrip("/")
        host, _, port = address.rpartition(":")
        if not host or not port.isdecimal() or not 0 < int(port) <= _LAST_PORT:
            raise _misunderstood(where)
        _require_dask()
        return Named(scheduler=address)
    if where == "dask":
        _require_dask()
        return Named()
    if not where.isdecimal() or not 1 <= int(where) <= _MOST:
        raise _misunderstood(where)
    return Named(int(where))


def has_dask() -> bool:
    """Whether Dask is installed."""
    return find_spec("distributed") is not None


def _require_dask() -> None:
    if not has_dask():
        raise ConfigurationError(
            "Workers on Dask need its package, which is not installed: pip install 'truepose[dask]', or "
            "leave --workers out."
        )


def _misunderstood(where: str) -> ConfigurationError:
    return ConfigurationError(
        f"--workers {where}: give a number of processes, `dask` for Dask on this computer, or "
        "dask://host:port of its scheduler."
    )
