"""Environments of the peers, made once under the output folder, and their programs run in them."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Final, NamedTuple

_PROGRAMS: Final = Path(__file__).parent / "peers"


class Peer(NamedTuple):
    """What is installed for a peer."""

    name: str
    program: str
    requirements: tuple[str, ...]


PEERS: Final = (
    Peer("pybotics", "pybotics_peer.py", ("pybotics", "numpy<2", "scipy")),
    Peer("figaroh", "figaroh_peer.py", ("figaroh",)),
    Peer("roboticstoolbox-python", "roboticstoolbox_peer.py", ("roboticstoolbox-python", "numpy<2")),
)


def times_of(peer: Peer, out: Path, arrays: Path) -> dict[str, dict[str, float]] | str:
    """Return the times that a peer's program prints, or one sentence why there are none."""
    python = out / f"venv-{peer.name}" / "bin" / "python"
    try:
        if not python.exists():
            _run(sys.executable, "-m", "venv", str(python.parents[1]))
            _run(str(python), "-m", "pip", "install", "--quiet", *peer.requirements)
        return json.loads(_run(str(python), str(_PROGRAMS / peer.program), str(arrays)))
    except subprocess.SubprocessError as error:
        last = (getattr(error, "stderr", None) or str(error)).strip().splitlines()[-1:]
        return f"{peer.name} was not timed: {''.join(last)}"


def _run(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=900).stdout
