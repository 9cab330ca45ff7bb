"""Programs as somebody types them: commands that end, and those that run until they are ended."""

import contextlib
import hashlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_PATIENCE_S: Final = 120.0
DASK: Final = str(Path(sys.executable).with_name("dask"))


@dataclass(frozen=True, slots=True)
class Answered:
    """What a command came to."""

    what: str
    status: int
    said: str  # its last line on standard error
    took_s: float
    same_bits: bool | None = None  # as one process gives; None: there are no results


@contextlib.contextmanager
def running(command: list[str], log: Path, ready: str, env: Mapping[str, str]) -> Iterator[None]:
    """Run a program, once its log says that it is ready, for as long as the context lasts."""
    with log.open("wb") as written:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=written,
            stderr=subprocess.STDOUT,
            env={**os.environ, **env},
            start_new_session=True,
        )
        try:
            _await(process, log, ready)
            yield
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(10.0)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def _await(process: "subprocess.Popen[bytes]", log: Path, ready: str) -> None:
    until_s = time.monotonic() + _PATIENCE_S
    while ready not in log.read_text(encoding="utf-8", errors="replace"):
        if process.poll() is not None or time.monotonic() > until_s:
            raise SystemExit(
                f"{log} does not say {ready!r}:\n{log.read_text(encoding='utf-8', errors='replace')[-2000:]}"
            )
        time.sleep(0.1)


class Archive:
    """Campaigns, computed by whatever workers, and held against what one process gives."""

    def __init__(self, campaigns: Path, out: Path) -> None:
        self._campaigns, self._out = campaigns, out
        self._expected: dict[str, str] = {}
        alone = self.computed("alone", "1", {})
        if alone.status:
            raise SystemExit(alone.said)
        self._expected = _bits(out / "alone")

    def computed(self, what: str, where: str, env: Mapping[str, str]) -> Answered:
        """Compute all campaigns anew as somebody types it."""
        out = self._out / what.replace(" ", "-")
        command = [sys.executable, "-m", "truepose", "reanalyse", str(self._campaigns), "--out", str(out)]
        began_s = time.monotonic()
        ended = subprocess.run(
            [*command, "--workers", where],
            env={**os.environ, **env},
            capture_output=True,
            text=True,
            check=False,
            timeout=5 * _PATIENCE_S,
        )
        lines = [line for line in ended.stderr.splitlines() if line.strip()]
        took_s = time.monotonic() - began_s
        found = _bits(out)
        same = found == self._expected if found and self._expected else None
        return Answered(what, ended.returncode, lines[-1] if lines else "", took_s, same)


def _bits(out: Path) -> dict[str, str]:
    files = sorted((out / "results").glob("*"))
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
