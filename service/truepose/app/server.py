"""The server of a cell's or a plant's service: who may reach it, started, watched, ended."""

import asyncio
import contextlib
import errno
import functools
import json
import logging
import os
import socket
import ssl
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Generic, TypeVar

import uvicorn

from truepose.app.connections import Census, Limits, close_slow_connections, connection_limit
from truepose.app.errors import PortInUseError, ScenarioRefusedError, UnsafeStartError
from truepose.app.http_protocol import WatchedProtocol
from truepose.app.logs import logged
from truepose.app.startup import ServiceContext, allowed_hosts, program_version, stop_streams
from truepose.domain.errors import TrueposeError
from truepose.effects.registry import unusable_causes
from truepose.exchange.errors import ExchangeError
from truepose.messages.error_codes import code_of
from truepose.processes import asked_to_end
from truepose.settings import Settings
from truepose.storage.engine.address import database_file
from truepose.storage.secret_files import ReachedService, publish_endpoint
from truepose.web.asgi import Application
from truepose.web.middleware.hosts import AddressError, AllowedHosts, Proxies
from truepose_drivers.errors import DriverError

_OPEN: Final = (
    "--no-accounts admits anyone who can reach the service, so it is allowed on this computer only: remove "
    "--host, --allowed-host and --behind-proxy, or remove --no-accounts."
)
_HALF: Final = "TLS needs both --tls-certificate FILE and --tls-key FILE."


def require_safe(settings: Settings) -> None:
    """Raise UnsafeStartError where a service would let in whoever reaches it."""
    if not settings.accounts and not settings.reached_from_here_alone:
        raise UnsafeStartError(_OPEN)
    if (settings.tls_certificate is None) != (settings.tls_key is None):
        raise UnsafeStartError(_HALF)


def speak_tls(config: uvicorn.Config, settings: Settings) -> str:
    """Have a server speak TLS 1.2 or newer where there is a certificate; return the scheme of its addresses.

    Raises UnsafeStartError where certificate and key cannot be used.
    """
    config.load()
    if settings.tls_certificate is None or settings.tls_key is None:
        return "http"
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(settings.tls_certificate, settings.tls_key)
    except (OSError, ssl.SSLError) as error:
        raise UnsafeStartError(
            f"{settings.tls_certificate} and {settings.tls_key} cannot be used as certificate and key "
            f"({error})."
        ) from error
    config.ssl = context
    return "https"


_MICROSECONDS: Final = 1e6
_OFTEN: Final = 3.0  # times within the time after which the service counts as hung


def tell(state: str) -> None:
    """Send a state to the service manager that started this process."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address or not hasattr(socket, "AF_UNIX"):
        return
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(state.encode(), f"\0{address[1:]}" if address.startswith("@") else address)


async def keep_telling() -> None:
    """Say that the event loop turns, as often as the service manager wants it; return where it does not."""
    hung_after_s = float(os.environ.get("WATCHDOG_USEC") or 0) / _MICROSECONDS
    while hung_after_s > 0:
        tell("WATCHDOG=1")
        await asyncio.sleep(hung_after_s / _OFTEN)


_LOG: Final = logging.getLogger(__name__)
_UNUSABLE_INPUT: Final = 2
_SERVICE_FAILED: Final = 3
_GRACE_S: Final = 5  # for requests under way when the service ends
# Most clients keep a connection for 5 or 15 s, and so end it before the service does: a request that
# meets the end of its connection is reset, and nobody knows whether it was carried out.
_KEPT_S: Final = 75
_AT_ONCE: Final = 128  # connections taken up before anything else is looked at again
_UNHEARD_MS: Final = 30_000  # after which a connection ends whose other side acknowledges nothing
_QUEUE: Final = 4096  # connections that wait in the system to be taken up; beyond, it asks them to come again


C = TypeVar("C", bound=ServiceContext)


@dataclass(frozen=True, slots=True)
class ServiceDefinition(Generic[C]):
    """A service: what opens all that is behind its routes, given how many lines of the log were lost."""

    opened: Callable[[Callable[[], int]], AbstractAsyncContextManager[C]]
    application: Callable[
        [str, Callable[[], AbstractAsyncContextManager[C]], AllowedHosts, Proxies], Application
    ]


def run(settings: Settings, served: ServiceDefinition[C]) -> int:
    """Serve until interrupted and return the exit status; prints one JSON line with `url` when ready.

    A start that fails writes one sentence to standard error: status 2 for a cell file, a scenario, an
    allowed host or a proxy that cannot be used, 3 for a database, a port or a simulated cell that cannot.
    """
    try:
        require_safe(settings)
        with logged(log_file(settings), settings.log_level.upper()) as lost:
            for loud in ("alembic", "httpx"):  # one line for every request to a cell
                logging.getLogger(loud).setLevel(logging.WARNING)
            for sentence in unusable_causes():
                _LOG.warning("%s", sentence)
            asyncio.run(_serve(settings, served, lambda: lost.lines))
    except KeyboardInterrupt:  # before the service was ready and took care of signals itself
        return 0
    except (ExchangeError, ScenarioRefusedError, UnsafeStartError, AddressError) as error:
        return _refuse(error, _UNUSABLE_INPUT)
    except (TrueposeError, DriverError) as error:
        return _refuse(error, _SERVICE_FAILED)
    return 0


def log_file(settings: Settings) -> Path:
    """Return where the log is written, by default beside the database; raises DatabaseAddressError."""
    if settings.log_file is not None:
        return settings.log_file
    database = database_file(settings.database_url)
    return database.with_name(f"{database.name}.log")


def _refuse(error: Exception, status: int) -> int:
    sys.stderr.write(f"{error} [{code_of(error)}]\n")
    return status


async def _serve(settings: Settings, served: ServiceDefinition[C], lines_lost: Callable[[], int]) -> None:
    hosts, proxies = allowed_hosts(settings), Proxies(settings.proxies)
    # The port first: a service that nobody can reach must not hold the database or start a cell.
    with _listening(settings.host, settings.port) as listener:
        census = Census(Limits(connection_limit()), proxies.includes)
        async with served.opened(lines_lost) as context, close_slow_connections(census):
            config = uvicorn.Config(
                served.application(
                    program_version(), lambda: contextlib.nullcontext(context), hosts, proxies
                ),
                # The server calls it like the class that it wants.
                http=functools.partial(WatchedProtocol, census),  # type: ignore[arg-type]
                ws="none",
                backlog=_AT_ONCE,
                proxy_headers=False,  # the door judges whose word counts
                server_header=False,
                access_log=False,
                log_config=None,
                log_level=logging.WARNING,
                timeout_keep_alive=_KEPT_S,
                timeout_graceful_shutdown=_GRACE_S,
            )
            url = _url(listener, speak_tls(config, settings))
            server = _Server(config, _said(context, url), lambda: stop_streams(context))
            with (
                asked_to_end(server.end),
                publish_endpoint(context.database.file, _reached(context, url, settings)),
            ):
                telling = asyncio.create_task(keep_telling(), name="service manager")
                try:
                    await server.serve([listener])
                finally:
                    telling.cancel()
    _LOG.info("stopped cleanly")


class _Server(uvicorn.Server):
    """Says when it is ready, and ends streams before it waits for connections to close."""

    def __init__(
        self, config: uvicorn.Config, said: dict[str, str], before_shutdown: Callable[[], None]
    ) -> None:
        super().__init__(config)
        self._said = said
        self._before_shutdown = before_shutdown

    def end(self) -> None:
        """End in order; at once where that was asked for before."""
        self.force_exit = self.should_exit
        self.should_exit = True

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        for listener in sockets or ():
            listener.listen(_QUEUE)
        sys.stdout.write(json.dumps(self._said) + "\n")
        sys.stdout.flush()
        _LOG.info("ready at %s", self._said["url"])
        tell("READY=1")

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        tell("STOPPING=1")
        self._before_shutdown()
        await super().shutdown(sockets)

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        # The base class raises the signal again at the end, which would skip our own closing.
        yield


def _cannot_listen(host: str, port: int, error: Exception) -> str:
    if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
        return f"Another program is listening at {host}:{port}: stop it, or choose another --port."
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return f"Cannot listen at {host}:{port} ({reason}): choose another --host or --port."


@contextlib.contextmanager
def _listening(host: str, port: int) -> Iterator[socket.socket]:
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        raise PortInUseError(_cannot_listen(host, port, error)) from error
    # Connections inherit it. asyncio sets it only where a socket names its protocol, which create_server
    # leaves open; without it the body of an answer waits 40 ms for the acknowledgement of its head.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    # A tablet without power takes nothing and says nothing; a quarter of an hour it would still watch.
    if sys.platform == "linux":
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNHEARD_MS)
    with listener:
        yield listener


def _said(context: ServiceContext, url: str) -> dict[str, str]:
    """Return what is told when the service is ready, and how the first person enters."""
    accounts = context.people.accounts
    if not accounts.asked_for or not accounts.nobody_entered:
        return {"url": url}
    link = f"{url}/first-person/{accounts.first_secret}"
    # Not through the log, which is kept.
    sys.stderr.write(f"There are no accounts yet. Create the first one, an administrator, here: {link}\n")
    return {"url": url, "first_person": link}


def _reached(context: ServiceContext, url: str, settings: Settings) -> ReachedService:
    """Return how commands of this machine reach the service."""
    certificate = settings.tls_certificate
    shown = None if certificate is None else str(certificate.resolve())
    return ReachedService(url, context.people.accounts.machine_secret, shown)


def _url(listener: socket.socket, scheme: str) -> str:
    """Return where it is reached; an address that stands for all is none, so this computer's own is said."""
    host, port = listener.getsockname()[:2]
    host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{port}"
