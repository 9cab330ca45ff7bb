"""Dask's own ways to many computers, tried on one: TLS with certificates on both sides, and SSH.

`python -m tests.studies.clusters --out out/clusters` makes certificates with openssl, starts a scheduler and
two workers that ask for them, and has `truepose reanalyse` compute a few campaigns there: with a certificate
of the same authority, without TLS, without a certificate, with one of another authority. With
`--sshd /usr/sbin/sshd` it starts that server on the loopback with a key of its own, and has workers started
through it by `SSHCluster` (package asyncssh) and by `dask ssh` (package paramiko). Everything that it starts
it ends. Printed and in clusters.json: the status of each command, what it said, how long it took, and whether
its results have the bits of one process of this computer.
"""

import os
import sys
from pathlib import Path

from tests.studies.archive.recorded import recorded_archive
from tests.studies.clusters.programs import Answered, Archive
from tests.studies.clusters.secure_shell import tried_through_ssh
from tests.studies.clusters.tls import tried_with_tls
from tests.studies.running import leave, study_options


def main() -> int:
    """Try them; status 1 where one that should compute does not, or one that should not does."""
    options = study_options(
        __doc__,
        out=Path,
        campaigns=4,
        readings=40,
        sshd=("", "absolute path of a server of SSH; without it SSH is left out"),
    )
    options.out.mkdir(parents=True)
    campaigns = options.out / "campaigns"
    recorded_archive(campaigns, options.campaigns, options.readings, ["irb120-clean"])
    archive = Archive(campaigns, options.out)
    found = list(map(_told, tried_with_tls(archive, options.out / "tls")))
    if options.sshd:
        found += map(_told, tried_through_ssh(archive, options.out / "ssh", options.sshd))
    leave(options.out, "clusters", {"load": os.getloadavg(), "tried": found})
    return 0 if all(map(_as_it_should, found)) else 1


def _told(one: Answered) -> Answered:
    bits = {None: "no results", True: "same bits", False: "OTHER BITS"}[one.same_bits]
    sys.stdout.write(f"{one.what}: status {one.status}, {bits}, {one.took_s:.1f} s. {one.said}\n")
    sys.stdout.flush()
    return one


def _as_it_should(one: Answered) -> bool:
    if one.what in {"with a certificate", "by SSHCluster", "by dask ssh"}:
        return one.status == 0 and one.same_bits is True
    return one.status == 3 and one.same_bits is None and "Dask" in one.said


if __name__ == "__main__":
    sys.exit(main())
