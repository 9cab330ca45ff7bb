"""What `--workers` says, refused before anything large is loaded, and whether such workers can be reached."""

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Final

from truepose.domain.errors import ConfigurationError

_SCHEME: Final = "dask://"
_MOST: Final = 1024  # processes
_LAST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class WorkerAddress:
    """So many processes, a scheduler, or Dask on this computer."""

    processes: int = 0
    scheduler: str = ""  # host:port

    @property
    def host_and_port(self) -> tuple[str, int]:
        """Of the scheduler."""
        host, _, port = self.scheduler.rpartition(":")
        return host.strip("[]"), int(port)


def worker_address(where: str) -> WorkerAddress:
    """Return what is meant; raises ConfigurationError for what cannot be, and where Dask is not installed."""
    if where.startswith(_SCHEME):
        address = where.removeprefix(_SCHEME).rstrip("/")
        host, _, port = address.rpartition(":")
        if not _is_host(host) or not port.isdecimal() or not 0 < int(port) <= _LAST_PORT:
            raise _misunderstood(where)
        _require_dask()
        return WorkerAddress(scheduler=address)
    if where == "dask":
        _require_dask()
        return WorkerAddress()
    if not where.isdecimal() or not 1 <= int(where) <= _MOST:
        raise _misunderstood(where)
    return WorkerAddress(int(where))


def _is_host(name: str) -> bool:
    # As names are looked up: there an empty label, or one too long, is no OSError as all other failures are.
    try:
        return bool(name.encode("idna"))
    except UnicodeError:
        return False


def has_dask() -> bool:
    """Whether Dask is installed."""
    return find_spec("distributed") is not None


def _require_dask() -> None:
    if not has_dask():
        raise ConfigurationError(
            "Dask workers need the Dask package, which is not installed: run pip install 'truepose[dask]', "
            "or omit --workers."
        )


def _misunderstood(where: str) -> ConfigurationError:
    return ConfigurationError(
        f"--workers {where}: give a number of processes, `dask` for Dask workers on this computer, or "
        "dask://host:port for a Dask scheduler."
    )


_AGAIN_S: Final = 30.0  # between two looks, and after a failure
_PATIENCE_S: Final = 1.0  # for a scheduler to take a connection


class Reach:
    """How workers stood when somebody looked last; a look takes a second at most.

    Raises ConfigurationError where `where` names none.
    """

    def __init__(self, where: str, now_s: Callable[[], float] = time.monotonic) -> None:
        self._scheduler = worker_address(where)
        self._now_s = now_s
        self._fault = ""
        self._seen_s = -_AGAIN_S

    async def fault(self) -> str:
        """Return in a sentence why they cannot be asked, empty where they can."""
        if self._now_s() - self._seen_s >= _AGAIN_S:
            self.seen(await self._looked())
        return self._fault

    def seen(self, fault: str) -> None:
        """Take what somebody met who asked them."""
        self._fault, self._seen_s = fault, self._now_s()

    async def _looked(self) -> str:
        if not self._scheduler.scheduler:
            return ""  # of this computer
        host, port = self._scheduler.host_and_port
        try:
            # Only whether somebody listens: a page asks, and to speak with a scheduler would load Dask into
            # the service.
            async with asyncio.timeout(_PATIENCE_S):
                _, writer = await asyncio.open_connection(host, port)
        except OSError:
            return f"No Dask scheduler answers at {self._scheduler.scheduler}."
        writer.close()
        with contextlib.suppress(OSError):
            await writer.wait_closed()
        return ""
