"""The service in this process, on a cell file that may be changed between two starts."""

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import httpx

from tests.studies.taken_up.cell_text import cell_text
from tests.studies.taken_up.ledger_on_disk import lines
from truepose.app.composition import open_context
from truepose.app.startup import program_version
from truepose.settings import Settings
from truepose.web.application import create_application
from truepose_simulators.instruments.endpoint import Address

_ANSWER_S = 300.0  # choosing poses takes half a minute, on a busy machine more


class ServiceHere:
    """Started, asked, ended and started again; the database stays."""

    def __init__(self, folder: Path, scenario: str, addresses: Sequence[Address]) -> None:
        self.database = folder / "sessions.sqlite3"
        self._cell_file = folder / "cell.toml"
        self._settings = Settings(f"sqlite:///{self.database}", cell_file=self._cell_file)
        self._scenario = scenario
        self._addresses = addresses
        self.tells_serial = any(address.protocol == "hid" for address in addresses)
        self._open: contextlib.AsyncExitStack | None = None
        self._http: httpx.AsyncClient | None = None
        self.describe()

    @property
    def http(self) -> httpx.AsyncClient:
        """A client of the running service."""
        if self._http is None:
            raise RuntimeError("the service is not running")
        return self._http

    def describe(self, limits: str = "") -> None:
        """Write the cell file; `limits` is its [limits] section."""
        self._cell_file.write_text(cell_text(self._scenario, self._addresses, limits), encoding="utf-8")

    async def start(self) -> None:
        """Start it on the cell file as it is now."""
        async with contextlib.AsyncExitStack() as stack:
            context = await stack.enter_async_context(open_context(self._settings))
            app = create_application(program_version(), lambda: contextlib.nullcontext(context))
            await stack.enter_async_context(app.router.lifespan_context(app))
            transport = httpx.ASGITransport(app)
            self._http = await stack.enter_async_context(
                httpx.AsyncClient(transport=transport, base_url="http://localhost", timeout=_ANSWER_S)
            )
            self._open = stack.pop_all()

    async def stop(self) -> None:
        """End it in order; a motion that is under way ends by itself."""
        if self._open is not None:
            await self._open.aclose()
        self._open = self._http = None

    def lines(self, after: int = 0) -> list[dict[str, Any]]:
        """Return the lines of all ledgers with a number above `after`, from the disk."""
        return lines(self.database, after)
