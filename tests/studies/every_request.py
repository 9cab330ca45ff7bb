"""Asks every operation what its document allows, and what it does not: python -m ... --out DIR.

All phases of schemathesis (examples, coverage, fuzzing, stateful) against a whole service on fake devices,
with every check but those that CONFIGURATION leaves out, each with its reason. Exit status 1: some failed.
"""

import argparse
import asyncio
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.integration.web.bench import CELL, Bench
from tests.integration.web.listening import listening
from truepose.analysis.workers.promising import PromiseTask
from truepose.app import create_app
from truepose.settings import Settings

CONFIGURATION = """
[[operations]]  # streams do not end by themselves
include-operation-id = ["follow_events", "follow_ballbar_session", "follow_guide"]
parameters = { "query.stop_after_s" = 0.2 }

[[operations]]  # that bytes are a campaign or a program is more than a schema can say
include-operation-id = ["upload_campaign", "correct_file"]
checks.positive_data_acceptance.enabled = false
"""


async def never_done(task, told):
    """Stand in for a worker: what is asked here is the interface, not the numerics."""
    if isinstance(task, PromiseTask):  # is waited for
        return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
    return await asyncio.sleep(3600)


def ask_everything(folder, examples, out, more=()):
    """Return the exit status of schemathesis; its report is in `out`."""
    (folder / "cell.toml").write_text(CELL)
    (folder / "schemathesis.toml").write_text(CONFIGURATION)
    where = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), never_done)) as url:
        command = [
            sys.executable,
            "-m",
            "schemathesis.cli",
            "--config-file",
            str(folder / "schemathesis.toml"),
        ]
        command += ["run", f"{url}/openapi.json", f"--max-examples={examples}", "--continue-on-failure"]
        command += ["--request-timeout=20", "--no-color", "--report=junit", *more, f"--report-dir={out}"]
        return subprocess.run(command, check=False).returncode


def main():
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--examples", type=int, default=50, help="of each operation and phase")
    parser.add_argument("--out", type=Path, default=Path("out/interface"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        return ask_everything(Path(folder), asked.examples, asked.out.resolve())


if __name__ == "__main__":
    sys.exit(main())
