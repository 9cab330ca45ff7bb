"""What the services of a cell and of a plant start alike: the database, copies, people, streams."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Coroutine
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Final, Protocol

from truepose.people.accounts import PeopleService, open_people
from truepose.people.secrets import Pins
from truepose.settings import Settings
from truepose.storage.backup.restoring import put_ready_in_place
from truepose.storage.backup.schedule import BackupSchedule
from truepose.storage.database import Database
from truepose.storage.engine.address import database_file
from truepose.storage.secret_files import Pepper
from truepose.web.middleware.hosts import AllowedHosts

_LOG: Final = logging.getLogger(__name__)
_AGAIN_S: Final = 10.0  # after a fault that may come again at once


def allowed_hosts(settings: Settings) -> AllowedHosts:
    """Return the names under which the service may be asked; raises UnusableHostError."""
    scheme = "http" if settings.tls_certificate is None else "https"
    return AllowedHosts(settings.allowed_hosts, settings.host, scheme)


@cache
def program_version() -> str:
    """Return the version of the program; a checkout that was never installed has none."""
    try:
        return version("truepose")
    except PackageNotFoundError:
        return "0+checkout"


def opened_database(url: str) -> Database:
    """Return the database of a service, which begins with the copy that 'truepose restore' has laid ready."""
    file = database_file(url)
    found = put_ready_in_place(file)
    if found is not None:
        head, kept = found
        before = "" if kept is None else f"; the previous database is kept as {kept}"
        _LOG.warning("%s: %d records restored, chain head %s%s", file, head.links, head.text, before)
    return Database(url)


def beside(
    stack: contextlib.AsyncExitStack, work: Callable[[], Coroutine[None, None, None]], name: str
) -> None:
    """Have work done as long as the stack is open; it is begun anew where it ends by a fault."""
    stack.push_async_callback(_end, asyncio.create_task(_keep_up(work, name), name=name))


def copies_of(settings: Settings, stack: contextlib.AsyncExitStack) -> BackupSchedule | None:
    """Have copies made as long as the stack is open, where some are wanted."""
    if settings.backups is None:
        return None
    copies = BackupSchedule(settings.database_url, settings.backups)
    beside(stack, copies.follow, "backup schedule")
    return copies


def people_of(
    database: Database, settings: Settings
) -> contextlib.AbstractAsyncContextManager[PeopleService]:
    """Return what opens everything about who asks."""
    own = None if settings.pin_secret is None else Pepper(settings.pin_secret)
    pins = Pins(own or Pepper.beside(database.file))
    return open_people(database, pins, asked_for=settings.accounts, alone=settings.reached_from_here_alone)


async def _keep_up(work: Callable[[], Coroutine[None, None, None]], name: str) -> None:
    while True:
        try:
            await work()
        # Whatever it is: nobody waits for this task, so that its end would show nowhere, and a service
        # without it would go on as if it were watched.
        except Exception:
            _LOG.exception("the %s failed; it restarts in %.0f s", name, _AGAIN_S)
        await asyncio.sleep(_AGAIN_S)


async def _end(task: asyncio.Task[None]) -> None:
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


class ServiceContext(Protocol):
    """What is behind the routes of any service."""

    @property
    def database(self) -> Database:
        """Where records are kept."""

    @property
    def people(self) -> PeopleService:
        """Who asks."""

    @property
    def stopping(self) -> asyncio.Event:
        """Set when the service ends."""


def stop_streams(context: ServiceContext) -> None:
    """End every event stream, so that their connections can close."""
    context.stopping.set()
    context.database.wake()
