"""The plant's service on a PostgreSQL server, as the manager and a metrologist ask it."""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeAlias

import httpx

from tests.helpers.ports import free_port
from tests.helpers.postgresql.server import Server
from tests.studies.managers_day.cells import CellAtWork
from tests.studies.managers_day.programs import Running, answered, until

METROLOGIST: Final = "Grace Hopper"
MANAGER: Final = "Mary Ward"
DATABASE: Final = "plant"
_CELL: Final = '[[cell]]\nname = "{name}"\nurl = "http://127.0.0.1:{port}"\ntoken_file = "{token}"\n'
_JOURNAL: Final = """SELECT c.name, b.id, j.link, j.hash FROM plant_journal j
    JOIN plant_branches b ON b.id = j.branch_id JOIN plant_cells c ON c.id = b.cell_id ORDER BY j.id"""
_ANSWER_S: Final = 30.0
Kept: TypeAlias = tuple[str, int, int, bytes]  # cell, branch, link, hash
_PAGE: Final = 100


@dataclass(slots=True)
class PlantAtWork:
    """A plant, its database and its service."""

    folder: Path
    server: Server
    port: int = field(default_factory=free_port)
    tokens: dict[str, str] = field(default_factory=dict)  # by person
    service: Running | None = None

    @property
    def url(self) -> str:
        """Where its pages are."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def database(self) -> str:
        """Its records, as commands are told."""
        return self.server.url(DATABASE)

    def tokens_file(self, cell: CellAtWork) -> Path:
        """Where the token for a cell lies."""
        return self.folder / f"{cell.name.replace(' ', '-').lower()}.token"

    def name_cells(self, cells: Sequence[CellAtWork]) -> None:
        """Write the cells file."""
        told = [
            _CELL.format(name=cell.name, port=cell.cable.port, token=self.tokens_file(cell).name)
            for cell in cells
        ]
        (self.folder / "cells.toml").write_text("\n".join(told), encoding="utf-8")

    def make_database(self) -> None:
        """Have the server make an empty database, in the place of one that may be there."""
        with self.server.connect() as connection:
            connection.execute(f"DROP DATABASE IF EXISTS {DATABASE} WITH (FORCE)")
            connection.execute(f"CREATE DATABASE {DATABASE}")

    async def enter(self, person: str, role: str) -> str:
        """Enter somebody and make them a token; the link by which they choose a password."""
        here = ("--database", self.database)
        told = await answered("people", "add", person, "--role", role, *here)
        made = await answered("people", "token", person, "--name", "script", "--role", role, *here)
        self.tokens[person] = made["secret"]
        return f"{self.url}{told['link']}"

    async def start(self) -> None:
        """Start its service; it visits each cell every second."""
        plant = ("plant", "--cells", str(self.folder / "cells.toml"), "--database", self.database)
        self.service, _ = await Running.serving(
            *(*plant, "--port", str(self.port), "--every", "1s", "--name", "Plant north"),
            log=self.folder / "plant.log",
            folder=self.folder,
        )

    async def stop(self) -> None:
        """End its service."""
        if self.service is not None:
            await self.service.ask_to_end()
            self.service = None

    async def get(self, path: str, person: str = MANAGER) -> Any:
        """Return what the plant answers somebody."""
        async with self._asked_by(person) as http:
            return (await http.get(f"/api/v1{path}")).raise_for_status().json()

    async def post(self, path: str, body: dict[str, Any], person: str) -> Any:
        """Have something done, by somebody."""
        async with self._asked_by(person) as http:
            answer = await http.post(f"/api/v1{path}", json=body)
            assert answer.is_success, answer.text
            return answer.json()

    async def status(self, path: str) -> int:
        """Return the status with which something is answered."""
        async with self._asked_by(MANAGER) as http:
            return (await http.get(path)).status_code

    @asynccontextmanager
    async def _asked_by(self, person: str) -> AsyncIterator[httpx.AsyncClient]:
        headers = {"Authorization": f"Bearer {self.tokens[person]}"}
        async with httpx.AsyncClient(
            base_url=self.url, headers=headers, timeout=_ANSWER_S, trust_env=False
        ) as http:
            yield http

    async def newest_visit(self, cell: CellAtWork) -> dict[str, Any]:
        """Return what came of the newest visit to a cell."""
        found: dict[str, Any] | None = (await self.get(f"/plant/cells/{cell.name}"))["cell"]["newest_visit"]
        return found or {"outcome": "none", "sentence": "", "head": None}

    async def visit_now(self, cell: CellAtWork) -> None:
        """Have a cell visited as soon as nobody visits it; one that was away is left alone for a while."""
        await self.post(f"/plant/cells/{cell.name}/visits", {}, METROLOGIST)

    async def says(self, cell: CellAtWork, outcome: str) -> dict[str, Any]:
        """Wait until the newest visit to a cell has an outcome, and return it."""

        async def look() -> dict[str, Any] | None:
            await self.visit_now(cell)
            visit = await self.newest_visit(cell)
            return visit if visit["outcome"] == outcome else None

        return await until(look, f"{cell.name} is {outcome}")

    async def has_all_of(self, cell: CellAtWork) -> str:
        """Wait until the plant's head of a cell is the cell's own, and return it."""
        token = self.tokens_file(cell).read_text(encoding="utf-8").strip()
        url = f"http://127.0.0.1:{cell.port}/api/v1/chain/head"

        async def look() -> str | None:
            async with httpx.AsyncClient(timeout=_ANSWER_S, trust_env=False) as http:
                answer = await http.get(url, headers={"Authorization": f"Bearer {token}"})
            await self.visit_now(cell)
            head: str = answer.raise_for_status().json()["head"]
            visit = await self.newest_visit(cell)
            return head if (visit["outcome"], visit["head"]) == ("whole", head) else None

        return await until(look, f"all of {cell.name} is collected")

    async def everything(self, kind: str) -> list[dict[str, Any]]:
        """Return a list of the plant, page by page."""
        found: list[dict[str, Any]] = []
        while True:
            after = found[-1]["id"] if found else 0
            page = await self.get(f"/plant/{kind}?after={after}&limit={_PAGE}")
            found += page
            if len(page) < _PAGE:
                return found

    def journal(self) -> list[Kept]:
        """Return what the plant has kept, in its order, read past its service."""
        with self.server.connect(DATABASE) as connection:
            return [
                (name, branch, link, bytes(hash)) for name, branch, link, hash in connection.execute(_JOURNAL)
            ]
