"""The reports of a run: identification and diagnosis, with the conditions that the service recorded.

The document comes over REST like every other. The report also draws curves and single errors, which the
document has no place for: they are read from the database that the ended service has left.
"""

import asyncio
import contextlib
import dataclasses
import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

from truepose.demo.cell_run import CellRun, SessionRecords
from truepose.demo.client import PERSON
from truepose.demo.processes import DATABASE
from truepose.demo.truth_comparison import JudgedRun
from truepose.domain.cell import Cell
from truepose.domain.diagnosis import Diagnosis
from truepose.exchange.cells.file import simulated_cell
from truepose.messages.message import message
from truepose.reports.diagnosis.report import DiagnosisReport
from truepose.reports.identification.report import DiagnosisLink, IdentificationReport
from truepose.reports.identification.summary import Truth
from truepose.reports.paper import print_page
from truepose.reports.traceability import Instrument, Period, ReportConditions
from truepose.storage.database import Database
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.models import ResultRepository

REPORT: Final = "report.html"
DIAGNOSIS_REPORT: Final = "diagnosis.html"
_ROLES: Final = {"tracker": "laser tracker", "robot": "robot controller"}


def write_report(judged: JudgedRun, file: Path) -> None:
    """Write the HTML report; raises UnwritableReportError."""
    run = judged.run
    cell = simulated_cell(run.request.scenario, run.request.seed)
    report = IdentificationReport(
        identification=judged.identification,
        campaign=run.campaign,
        conditions=report_conditions(run.records, cell),
        truth=_truth(judged),
        diagnosis=DiagnosisLink(DIAGNOSIS_REPORT, run.diagnosis["document"]["message"]),
    )
    report.write(file)


def print_reports(folder: Path) -> None:
    """Write the pages of a run as PDFs beside them, all at once; raises NoPdfError, UnwritableReportError."""
    pages = [folder / name for name in (REPORT, DIAGNOSIS_REPORT) if (folder / name).is_file()]
    with ProcessPoolExecutor(max(len(pages), 1), mp_context=get_context("spawn")) as printers:
        list(printers.map(print_page, pages))


def _truth(judged: JudgedRun) -> Truth | None:
    if judged.errors is None:
        return None
    errors = (
        (message("truth.absolute"), judged.errors.absolute),
        (message("truth.aligned"), judged.errors.aligned),
    )
    return Truth(parameters=judged.parameters, errors=errors)


def report_conditions(records: SessionRecords, described: Cell) -> ReportConditions:
    """Return the conditions as the service recorded them, and the artefacts that the cell describes."""
    cell, plan = records.cell, records.plan
    registration = records.calibration["registration"] or {}
    return ReportConditions(
        simulated=cell["simulated"],
        instruments=tuple(_instrument(device) for device in records.devices),
        artefacts=tuple(artefact for artefact in (described.tool, described.world) if artefact is not None),
        robot_serial_number=cell["robot_serial_number"],
        person=PERSON,
        written_at=datetime.now(UTC).isoformat(timespec="seconds"),
        load=cell["load"],
        warm_up=cell["warm_up"],
        approach=_approach(plan["approach_offset_deg"]),
        tool_speed_mm_s=plan["tool_speed_mm_s"],
        orientation_speed_rad_s=math.radians(plan["orientation_speed_deg_s"]),
        settle_s=plan["settle_s"],
        measure_s=plan["measure_s"],
        sessions=(_period("calibration", records.calibration), _period("validation", records.validation)),
        two_face_mm=registration.get("two_face_mm"),
        registration_rms_mm=registration.get("rms_mm"),
        scale=registration.get("scale"),
        scale_standard_uncertainty=registration.get("scale_standard_uncertainty"),
        notes=(*_plant(described), *records.calibration["notes"], *records.validation["notes"]),
    )


def _plant(described: Cell) -> tuple[str, ...]:
    simulated = described.simulated
    return () if simulated is None else (f"Scenario {simulated.scenario}, seed {simulated.seed}.",)


def _instrument(device: dict[str, Any]) -> Instrument:
    return Instrument(
        role=_ROLES.get(device["kind"], device["kind"]),
        manufacturer=device["manufacturer"] or "",
        model=device["model"] or "",
        serial_number=device["serial_number"] or "",
        firmware=device["firmware"] or "",
        certificate=device["certificate"],
    )


def _approach(offset_deg: float | None) -> str:
    if offset_deg is None:
        return "mixed directions"
    return f"all joints from {offset_deg:+g} deg"


def _period(name: str, session: dict[str, Any]) -> Period:
    began = (state["recorded_at"] for state in session["states"] if state["state"] == "running")
    return Period(name, next(began, ""), session["state_since"])


def write_diagnosis(run: CellRun, folder: Path) -> None:
    """Write the report of the diagnosis into the folder of the run; raises UnwritableReportError."""
    diagnosis = asyncio.run(_stored(folder / DATABASE, run.diagnosis["id"]))
    conditions = report_conditions(run.records, simulated_cell(run.request.scenario, run.request.seed))
    name = f"scenario {Path(run.request.scenario).stem}, seed {run.request.seed}"
    DiagnosisReport(diagnosis, name, conditions=conditions).write(folder / DIAGNOSIS_REPORT)


async def _stored(database: Path, number: int) -> Diagnosis:
    with contextlib.closing(Database(f"sqlite:///{database.resolve()}")) as opened:
        record = await DiagnosisRepository(opened).get(number)
        if record.model_id is None:
            return record.diagnosis
        model = (await ResultRepository(opened).model(record.model_id)).model
    return dataclasses.replace(record.diagnosis, model=model)


def diagnosis_lines(document: dict[str, Any]) -> Iterator[str]:
    """Yield outcome and message and, of each finding, the sentence with how sure it is."""
    yield document["outcome"]
    yield f"Diagnosis: {document['message']}"
    for number, finding in enumerate(document["findings"], start=1):
        yield f"  {number}. {finding['sentence']} ({finding['confidence']})"
