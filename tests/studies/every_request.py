"""Asks every operation what its document allows, and what it does not: python -m ... --out DIR.

All phases of schemathesis (examples, coverage, fuzzing, stateful) against a whole service on fake devices,
first by any numbers of records, then by those that are there; with every check but what CONFIGURATION
leaves out, with its reason. Exit status 1: some failed.
"""

import argparse
import asyncio
import subprocess
import sys
import tempfile
from pathlib import Path

import httpx

from tests.helpers.domain.builders import make_campaign, make_points
from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.calibration.test_jobs import FakeWorker
from tests.integration.web.listening import listening
from truepose.analysis.workers.promising import PromiseTask
from truepose.analysis.workers.tasks import IdentifyTask, ValidateTask
from truepose.app import create_app
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.settings import Settings

CONFIGURATION = """
[[operations]]  # streams do not end by themselves
include-operation-id = ["follow_events", "follow_ballbar_session", "follow_guide"]
parameters = {{ "query.stop_after_s" = 0.2{known} }}

[[operations]]  # that bytes are a campaign or a program is more than a schema can say
include-operation-id = ["upload_campaign", "correct_file"]
checks.positive_data_acceptance.enabled = false
"""
THERE = '"path.id" = 1'


class Worker(FakeWorker):
    """Answers at once what makes records; of the rest what is asked is the interface, not the numerics."""

    async def __call__(self, task, told):
        if isinstance(task, PromiseTask):
            return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
        if isinstance(task, IdentifyTask | ValidateTask):
            return await super().__call__(task, told)
        return await asyncio.sleep(3600)


def furnish(url):
    """Make one record of each kind."""
    archive = write_campaign_zip(make_campaign(validation=make_points()))
    with httpx.Client(base_url=f"{url}/api/v1") as http:
        http.post("/sessions", json=session_request()).raise_for_status()
        http.post("/campaigns", content=archive, headers={"Content-Type": "application/zip"})
        for path, wanted in (("/identifications", {}), ("/validations", {"model_id": 1})):
            job = http.post(path, json={"campaign_id": 1, **wanted}).raise_for_status().json()
            while job["state"] in {"queued", "running"}:
                job = http.get(f"/jobs/{job['id']}").json()


def ask_everything(folder, examples, out, known="", more=()):
    """Return the exit status of schemathesis; its report is in `out`. `known`: parameters that are set."""
    (folder / "cell.toml").write_text(CELL)
    said = CONFIGURATION.format(known=f", {known}" if known else "")
    settings = folder / "schemathesis.toml"
    settings.write_text((f"parameters = {{ {known} }}\n" if known else "") + said)
    where = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), Worker())) as url:
        furnish(url)
        command = [sys.executable, "-m", "schemathesis.cli", f"--config-file={settings}"]
        command += ["run", f"{url}/openapi.json", f"--max-examples={examples}", "--continue-on-failure"]
        command += ["--request-timeout=120", "--no-color", "--report=junit", *more, f"--report-dir={out}"]
        return subprocess.run(command, check=False).returncode


def main():
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--examples", type=int, default=50, help="of each operation and phase")
    parser.add_argument("--out", type=Path, default=Path("out/interface"))
    asked = parser.parse_args()
    status = 0
    for name, known in (("any", ""), ("there", THERE)):
        out = (asked.out / name).resolve()
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            status = max(status, ask_everything(Path(folder), asked.examples, out, known))
    return status


if __name__ == "__main__":
    sys.exit(main())
