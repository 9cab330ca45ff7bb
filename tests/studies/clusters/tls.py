"""A scheduler and two workers with certificates, asked by who has one, who has none and who has another's."""

import contextlib
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from tests.helpers.ports import free_port
from tests.studies.clusters.programs import DASK, Answered, Archive, running

_DAYS: Final = "2"
_KEY: Final = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")


def tried_with_tls(archive: Archive, out: Path) -> Iterator[Answered]:
    """Yield what each of those who ask comes to."""
    ours, theirs = _authority(out / "ours"), _authority(out / "theirs")
    names = ("scheduler", "worker", "client")
    for name in names:
        _certificate(ours, name)
    _certificate(theirs, "client")
    inside = _configuration(out / "inside", ours, ours)
    with _scheduler_and_workers(out, inside) as address:
        where = f"dask://{address}"
        yield archive.computed("with a certificate", where, {"DASK_CONFIG": str(inside)})
        yield archive.computed("without TLS", where, {"DASK_CONFIG": str(_empty(out / "plain"))})
        bare = _configuration(out / "bare", ours, None)
        yield archive.computed("without a certificate", where, {"DASK_CONFIG": str(bare)})
        other = _configuration(out / "other", ours, theirs)
        yield archive.computed("with a certificate of others", where, {"DASK_CONFIG": str(other)})
        unknown = _configuration(out / "unknown", theirs, ours)
        yield archive.computed("with another authority", where, {"DASK_CONFIG": str(unknown)})


@contextlib.contextmanager
def _scheduler_and_workers(out: Path, configuration: Path) -> Iterator[str]:
    address, env = f"127.0.0.1:{free_port()}", {"DASK_CONFIG": str(configuration)}
    host, port = address.split(":")
    scheduler = [DASK, "scheduler", "--host", host, "--port", port, "--no-dashboard"]
    worker = [DASK, "worker", f"tls://{address}", "--nthreads", "1", "--host", host, "--no-dashboard"]
    with contextlib.ExitStack() as held:
        held.enter_context(running(scheduler, out / "scheduler.log", "Scheduler at:", env))
        for number in (1, 2):
            held.enter_context(running(worker, out / f"worker-{number}.log", "Registered to:", env))
        yield address


def _authority(folder: Path) -> Path:
    folder.mkdir(parents=True)
    subject = ("-subj", f"/CN={folder.name}", "-days", _DAYS)
    _openssl("req", "-x509", *_KEY, "-keyout", folder / "ca.key", "-out", folder / "ca.pem", *subject)
    return folder


def _certificate(authority: Path, name: str) -> None:
    """Make a key and a certificate of an authority."""
    key, request = authority / f"{name}.key", authority / f"{name}.csr"
    signed_by = ("-CA", authority / "ca.pem", "-CAkey", authority / "ca.key", "-CAcreateserial")
    _openssl("req", *_KEY, "-keyout", key, "-out", request, "-subj", f"/CN={name}")
    _openssl("x509", "-req", "-in", request, *signed_by, "-days", _DAYS, "-out", authority / f"{name}.pem")


def _openssl(*words: str | Path) -> None:
    subprocess.run(["openssl", *map(str, words)], check=True, capture_output=True)


def _configuration(folder: Path, trusted: Path, of: Path | None) -> Path:
    """Write what docs/computing.md says, for who trusts an authority and has certificates of one, or none."""
    _empty(folder)
    names = ("scheduler", "worker", "client")
    own = (
        ""
        if of is None
        else "".join(f"      {name}: {{cert: {of / name}.pem, key: {of / name}.key}}\n" for name in names)
    )
    (folder / "tls.yaml").write_text(
        "distributed:\n  comm:\n    require-encryption: true\n    tls:\n"
        f"      ca-file: {trusted / 'ca.pem'}\n{own}"
    )
    return folder


def _empty(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder
