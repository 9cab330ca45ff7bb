"""A server without a keeper: started and killed by whoever studies what becomes of its databases then."""

import asyncio
import contextlib
import os
import shutil
import signal
import subprocess
from pathlib import Path

import psycopg

from tests.helpers.postgresql.server import programs

_OWNER = "postgres"  # a server refuses the superuser
_OPTIONS = (
    "listen_addresses=",
    "shared_buffers=32MB",
    "max_connections=60",
    "recovery_init_sync_method=syncfs",  # one call where there would be one for each file
)
_AGAIN_S = 0.05
_PATIENCE_S = 120.0


class BareServer:
    """A server with its data in a folder, where it goes on when it is started again."""

    def __init__(self, folder: Path, data: Path | None = None) -> None:
        self._folder, self._data = folder, folder / "data" if data is None else data
        self._process: asyncio.subprocess.Process | None = None

    def make(self, *databases: str, log: Path | None = None) -> None:
        """Make server and databases where there are none; where `log` is named, pieces of 1 MB lie there."""
        if (self._data / "PG_VERSION").exists():
            return
        for place in (self._folder, self._data, *([] if log is None else [log])):
            place.mkdir(parents=True, exist_ok=True)
            if os.getuid() == 0:
                shutil.chown(place, _OWNER, _OWNER)
        self._data.chmod(0o700)
        made = [str(programs() / "initdb"), "-k", "-D", str(self._data), "-U", _OWNER, "-A", "trust"]
        made += ["-E", "UTF8", "--locale=C.UTF-8", *([] if log is None else ["--wal-segsize=1"])]
        made += [] if log is None else ["-X", str(log)]
        subprocess.run(made, check=True, stdout=subprocess.DEVNULL, cwd=self._folder, **_as_owner())
        text = "".join(f"CREATE DATABASE {name}\n" for name in databases)
        alone = [str(programs() / "postgres"), "--single", "-D", str(self._data), "postgres"]
        subprocess.run(
            alone,
            input=text.encode(),
            check=True,
            stdout=subprocess.DEVNULL,
            cwd=self._folder,
            **_as_owner(),
        )

    def url(self, database: str) -> str:
        """Return the address of a database."""
        return f"postgresql://{_OWNER}@/{database}?host={self._folder}"

    async def start(self) -> None:
        """Start it, again where processes of the one before hang on, and return once it answers."""
        async with asyncio.timeout(_PATIENCE_S):
            while not await self.answers():
                if self._process is None or self._process.returncode is not None:
                    await self._spawn()
                await asyncio.sleep(_AGAIN_S)

    async def _spawn(self) -> None:
        given = [part for option in _OPTIONS for part in ("-c", option)]
        given += ["-c", f"unix_socket_directories={self._folder}"]
        with (self._folder / "log").open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(str(programs() / "postgres"), "-D", str(self._data), *given),
                stdout=log,
                stderr=log,
                cwd=self._folder,
                start_new_session=True,
                **_as_owner(),
            )

    @property
    def ended(self) -> bool:
        """Whether it was started and has ended."""
        return self._process is not None and self._process.returncode is not None

    async def answers(self) -> bool:
        """Whether somebody can connect."""
        return await asyncio.to_thread(self._connects)

    def _connects(self) -> bool:
        try:
            psycopg.connect(f"host={self._folder} user={_OWNER} dbname=postgres", connect_timeout=5).close()
        except psycopg.OperationalError:
            return False
        return True

    async def kill(self) -> None:
        """Kill the process that started all others (`kill -9`)."""
        await self._end(signal.SIGKILL)

    async def stop_at_once(self) -> None:
        """Have all of it end without tidying up, as `pg_ctl stop -m immediate` does."""
        await self._end(signal.SIGQUIT)

    async def _end(self, how: signal.Signals) -> None:
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(how)
            await self._process.wait()

    def backends(self, databases: tuple[str, ...]) -> list[int]:
        """Return the processes that serve connections to some databases."""
        if self._process is None:
            return []
        children = Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children").read_text(
            encoding="utf-8"
        )
        return [int(child) for child in children.split() if _serves(child, databases)]


def _serves(process: str, databases: tuple[str, ...]) -> bool:
    try:
        words = Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")[0].decode().split()
    except OSError:  # it has ended
        return False
    return len(words) > 2 and words[2] in databases


def _as_owner() -> dict[str, str]:
    return {"user": _OWNER, "group": _OWNER} if os.getuid() == 0 else {}
