"""The report of a run, with the conditions that the service recorded of its sessions."""

import math
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

from truepose.demo.cell.client import PERSON
from truepose.demo.cell.run import SessionRecords
from truepose.demo.truth_comparison import JudgedRun
from truepose.domain.cell.description import Cell
from truepose.domain.sentences import said
from truepose.exchange.cells.file import simulated_cell
from truepose.reports import (
    DiagnosisLink,
    Instrument,
    Period,
    ReportConditions,
    ReportInput,
    Truth,
    write_identification_report,
)
from truepose.reports.paper import print_page

REPORT: Final = "report.html"
DIAGNOSIS_REPORT: Final = "diagnosis.html"
_ROLES: Final = {"tracker": "laser tracker", "robot": "robot controller"}


def write_report(judged: JudgedRun, file: Path) -> None:
    """Write the HTML report; raises UnwritableReportError."""
    run = judged.run
    cell = simulated_cell(run.request.scenario, run.request.seed)
    report = ReportInput(
        identification=judged.identification,
        campaign=run.campaign,
        conditions=report_conditions(run.records, cell),
        truth=_truth(judged),
        diagnosis=DiagnosisLink(DIAGNOSIS_REPORT, run.diagnosis["document"]["message"]),
    )
    write_identification_report(file, report)


def print_reports(folder: Path) -> None:
    """Write the pages of a run as PDFs beside them, all at once; raises NoPdfError, UnwritableReportError."""
    pages = [folder / name for name in (REPORT, DIAGNOSIS_REPORT) if (folder / name).is_file()]
    with ProcessPoolExecutor(max(len(pages), 1), mp_context=get_context("spawn")) as printers:
        list(printers.map(print_page, pages))


def _truth(judged: JudgedRun) -> Truth | None:
    if judged.errors is None:
        return None
    errors = (
        (said("truth.absolute"), judged.errors.absolute),
        (said("truth.aligned"), judged.errors.aligned),
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
