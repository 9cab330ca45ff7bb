"""Workers that are started through SSH, by `SSHCluster` and by `dask ssh`, on this computer alone."""

import contextlib
import getpass
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.helpers.ports import free_port
from tests.studies.clusters.programs import DASK, Answered, Archive, running

_HANDED_ON: Final = ("PYTHONPATH", "TRUEPOSE_DATA")  # to who signs in: there nobody has installed anything
_SSH_CLUSTER: Final = """
import json, signal, sys
from distributed import SSHCluster

if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    with SSHCluster(**json.loads(sys.argv[1])) as cluster:
        print("asked at", cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@dataclass(frozen=True, slots=True)
class _Server:
    """A server of SSH on the loopback, and the key that it lets in."""

    port: int
    key: Path
    user: str


def tried_through_ssh(archive: Archive, out: Path, sshd: str) -> Iterator[Answered]:
    """Yield what comes of workers that were started in either way."""
    out.mkdir()
    with _served(out, sshd) as server:
        with _ssh_cluster(server, out) as address:
            yield archive.computed("by SSHCluster", f"dask://{address}", {})
        with _dask_ssh(server, out) as address:
            yield archive.computed("by dask ssh", f"dask://{address}", {})


@contextlib.contextmanager
def _served(out: Path, sshd: str) -> Iterator[_Server]:
    keys = {name: out / name for name in ("host", "user")}
    for key in keys.values():
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(key)], check=True)
    server = _Server(free_port(), keys["user"], getpass.getuser())
    handed_on = " ".join(f"{name}={os.environ[name]}" for name in _HANDED_ON if name in os.environ)
    configuration = out / "sshd.conf"
    configuration.write_text(
        f"Port {server.port}\nListenAddress 127.0.0.1\nHostKey {keys['host']}\nPidFile none\nUsePAM no\n"
        f"AuthorizedKeysFile {keys['user']}.pub\nStrictModes no\nPasswordAuthentication no\n"
        f"PermitRootLogin prohibit-password\nAllowUsers {server.user}\n"
        + (f"SetEnv {handed_on}\n" if handed_on else "")
    )
    command = [sshd, "-D", "-e", "-f", str(configuration)]
    with running(command, out / "sshd.log", "Server listening on 127.0.0.1", {}):
        yield server


@contextlib.contextmanager
def _ssh_cluster(server: _Server, out: Path) -> Iterator[str]:
    sign_in = {"port": server.port, "username": server.user, "client_keys": [str(server.key)]}
    asked = {
        "hosts": ["127.0.0.1"] * 3,
        "connect_options": {**sign_in, "known_hosts": None},
        "worker_options": {"nthreads": 1},
        "scheduler_options": {"host": "127.0.0.1", "port": 0, "dashboard": False},
    }
    log = out / "ssh-cluster.log"
    with running([sys.executable, "-c", _SSH_CLUSTER, json.dumps(asked)], log, "asked at", {}):
        yield log.read_text().split("asked at tcp://")[1].split()[0]


@contextlib.contextmanager
def _dask_ssh(server: _Server, out: Path) -> Iterator[str]:
    port = free_port()
    sign_in = (
        "--ssh-port",
        str(server.port),
        "--ssh-username",
        server.user,
        "--ssh-private-key",
        str(server.key),
    )
    workers = (
        "--scheduler-port",
        str(port),
        "--nworkers",
        "2",
        "--nthreads",
        "1",
        "--remote-python",
        sys.executable,
    )
    command = [DASK, "ssh", "--scheduler", "127.0.0.1", *sign_in, *workers, "127.0.0.1"]
    with running(command, out / "dask-ssh.log", "Registered to:", {}):
        yield f"127.0.0.1:{port}"
