"""Keeps a server for as long as somebody has its pipe open, however they end; then nothing is left of it.

`python keeper.py FOLDER BIN [OPTION=VALUE ...]`: a cluster is made in FOLDER with the programs of BIN;
FOLDER/users is the pipe, FOLDER/ready appears when the server answers.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path


def as_owner(command, folder):
    """Return a command so that it runs as somebody who may: a server refuses the superuser."""
    if os.getuid() == 0:
        shutil.chown(folder, "postgres", "postgres")
        return ["runuser", "-u", "postgres", "--", *command]
    return command


def main(folder, programs, *options):
    with (folder / "log").open("ab") as log:
        made = [str(programs / "initdb"), "-D", str(folder / "data"), "-U", "postgres", "-A", "trust"]
        made += ["--no-sync", "-E", "UTF8", "--locale=C.UTF-8"]
        subprocess.run(as_owner(made, folder), stdout=log, stderr=log, check=True, cwd=folder)
        given = [part for option in options for part in ("-c", option)]
        own = ["-c", "listen_addresses=", "-c", f"unix_socket_directories={folder}", *given]
        command = [str(programs / "postgres"), "-D", str(folder / "data"), *own]
        server = subprocess.Popen(as_owner(command, folder), stdout=log, stderr=log, cwd=folder)
    try:
        answers = [str(programs / "pg_isready"), "-q", "-h", str(folder)]
        while subprocess.run(answers, check=False).returncode:
            if server.poll() is not None:
                sys.exit("the server did not start")
            time.sleep(0.05)
        (folder / "ready").touch()
        with (folder / "users").open("rb") as users:
            users.read()  # to its end: nobody has it open any more
    finally:
        (folder / "ready").unlink(missing_ok=True)
        running = folder / "data/postmaster.pid"
        if running.exists():  # a test may have stopped it
            os.kill(int(running.read_text().split()[0]), signal.SIGQUIT)
        while running.exists():  # one that was started again is nobody's child here
            time.sleep(0.05)
        server.wait()
        shutil.rmtree(folder)


if __name__ == "__main__":
    os.setsid()
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
