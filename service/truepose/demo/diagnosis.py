"""The diagnosis of a run: its report beside that of the identification, and its lines for people.

The document comes over REST like every other. The report also draws curves and single errors, which the
document has no place for: they are read from the database that the ended service has left.
"""

import asyncio
import contextlib
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from truepose.demo.cell.opened import DATABASE
from truepose.demo.cell.run import CellRun
from truepose.demo.report import DIAGNOSIS_REPORT, report_conditions
from truepose.domain.results.diagnosis import Diagnosis
from truepose.exchange.cells.file import simulated_cell
from truepose.reports import DiagnosisInput, write_diagnosis_report
from truepose.storage.calibration.diagnoses import DiagnosisRepository
from truepose.storage.calibration.results import ResultRepository
from truepose.storage.database import Database


def write_diagnosis(run: CellRun, folder: Path) -> None:
    """Write the report of the diagnosis into the folder of the run; raises UnwritableReportError."""
    diagnosis = asyncio.run(_stored(folder / DATABASE, run.diagnosis["id"]))
    conditions = report_conditions(run.records, simulated_cell(run.request.scenario, run.request.seed))
    name = f"scenario {Path(run.request.scenario).stem}, seed {run.request.seed}"
    write_diagnosis_report(folder / DIAGNOSIS_REPORT, DiagnosisInput(diagnosis, name, conditions))


async def _stored(database: Path, number: int) -> Diagnosis:
    with contextlib.closing(Database(f"sqlite:///{database.resolve()}")) as opened:
        record = await DiagnosisRepository(opened).get(number)
        if record.model_id is None:
            return record.diagnosis
        model = (await ResultRepository(opened).model(record.model_id)).model
    return dataclasses.replace(record.diagnosis, model=model)


def diagnosis_lines(document: dict[str, Any]) -> Iterator[str]:
    """Yield the message and, of each finding, the sentence with how sure it is."""
    yield f"Diagnosis: {document['message']}"
    for number, finding in enumerate(document["findings"], start=1):
        yield f"  {number}. {finding['sentence']} ({finding['confidence']})"
