"""Asks every operation what its document allows, and what it does not: python -m ... --out DIR.

All phases of schemathesis (examples, coverage, fuzzing, stateful) against a whole service on fake devices:
by any numbers of records, by those that are there, and as a program of an administrator where accounts are
on; with every check but what CONFIGURATION leaves out, with its reason. An evening can be had in slices, by
--manner, --phases and --part 2/8. Exit status 1: some failed.
"""

import asyncio
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import httpx

from tests.helpers.domain.builders import make_campaign, make_points
from tests.integration.web.bench import CELL, Bench, session_request
from tests.integration.web.calibration.test_jobs import FakeWorker
from tests.integration.web.listening import listening
from tests.studies.running import study_parser
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.analysis.job_queue.tasks import IdentifyTask, ValidateTask
from truepose.app import create_app
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.settings import Settings

CONFIGURATION = """
[[operations]]  # streams do not end by themselves
include-operation-id = ["follow_events", "follow_session"]
parameters = {{ "query.stop_after_s" = 0.2{known} }}

[[operations]]  # that bytes are a campaign or a program is more than a schema can say
include-operation-id = ["upload_campaign", "correct_file"]
checks.positive_data_acceptance.enabled = false
"""


PATIENCE_S = 120


class Worker(FakeWorker):
    """Answers at once what makes records; of the rest what is asked is the interface, not the numerics."""

    async def __call__(self, task, told):
        if isinstance(task, PromiseTask):
            return await asyncio.to_thread(task.perform, lambda fraction, doing: None)
        if isinstance(task, IdentifyTask | ValidateTask):
            return await super().__call__(task, told)
        return await asyncio.sleep(3600)


def furnish(http):
    """Make one record of each kind."""
    archive = write_campaign_zip(make_campaign(validation=make_points()))
    http.post("/sessions", json=session_request()).raise_for_status()
    http.post("/campaigns", content=archive, headers={"Content-Type": "application/zip"})
    for path, wanted in (("/identifications", {}), ("/validations", {"model_id": 1})):
        job = http.post(path, json={"campaign_id": 1, **wanted}).raise_for_status().json()
        while job["state"] in {"queued", "running"}:
            job = http.get(f"/jobs/{job['id']}").json()


@dataclass(frozen=True)
class Manner:
    """How the service is asked."""

    known: str = ""  # parameters that are set
    signed_in: bool = False


MANNERS = {
    "any": Manner(),
    "there": Manner('"path.id" = 1'),
    "administrator": Manner(signed_in=True),
}


def administrator(database):
    """Return the token of an administrator's program; others are entered before them, who may be removed."""
    for name in ("Ada Byron", *(f"Person {k}" for k in range(20)), "Grace Hopper"):
        on_accounts(database, "add", name, "--role", "administrator")
    made = on_accounts(database, "token", name, "--name", "every request", "--role", "administrator")
    return made["secret"]


def on_accounts(database, *words):
    command = [sys.executable, "-m", "truepose", "people", *words, "--database", database, "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def ask_everything(folder, manner, out, options):
    """Return the exit status of schemathesis with these options; its report is in `out`."""
    (folder / "cell.toml").write_text(CELL)
    said = CONFIGURATION.format(known=f", {manner.known}" if manner.known else "")
    settings = folder / "schemathesis.toml"
    settings.write_text((f"parameters = {{ {manner.known} }}\n" if manner.known else "") + said)
    database = f"sqlite:///{folder}/truepose.sqlite3"
    headers = {"Authorization": f"Bearer {administrator(database)}"} if manner.signed_in else {}
    where = Settings(database_url=database, cell_file=folder / "cell.toml")
    with listening(create_app(where, Bench().registry(), Worker())) as url:
        with httpx.Client(base_url=f"{url}/api/v1", headers=headers, timeout=PATIENCE_S) as http:
            http.get(f"{url}/openapi.json").raise_for_status()  # on a busy computer it takes a while to make
            furnish(http)
        command = [sys.executable, "-m", "schemathesis.cli", f"--config-file={settings}"]
        command += ["run", f"{url}/openapi.json", *options, f"--report-dir={out}"]
        command += [f"--header={name}: {value}" for name, value in headers.items()]
        command += ["--continue-on-failure", "--request-timeout=120", "--no-color", "--report=junit"]
        return subprocess.run(command, check=False).returncode


def of_part(part):
    """Return the operations of a part, `2/8`, as options; every eighth one, so that parts are alike."""
    number, of = map(int, part.split("/"))
    names = sorted(
        operation["operationId"]
        for methods in create_app(Settings()).openapi()["paths"].values()
        for operation in methods.values()
    )
    return [f"--include-operation-id={name}" for name in names[number - 1 :: of]]


def main():
    """Run it."""
    parser = study_parser(
        __doc__,
        out=Path("out/interface"),
        examples=(50, "of each operation and phase"),
        phases="examples,coverage,fuzzing,stateful",
        part=("1/1", "of the operations, as 2/8"),
    )
    parser.add_argument("--manner", choices=MANNERS, action="append", help="by default every one")
    asked = parser.parse_args()
    options = [f"--max-examples={asked.examples}", f"--phases={asked.phases}", *of_part(asked.part)]
    status = 0
    for name in asked.manner or MANNERS:
        out = (asked.out / name).resolve()
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            status = max(status, ask_everything(Path(folder), MANNERS[name], out, options))
    return status


if __name__ == "__main__":
    sys.exit(main())
