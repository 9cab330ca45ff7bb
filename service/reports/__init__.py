"""Reports: self-contained HTML pages and short text tables from results."""

from service.reports.conditions import Instrument, Period, ReportConditions
from service.reports.identification_report import ReportInput, write_identification_report
from service.reports.table_report import Row, Section, Verdict, write_table_report
from service.reports.truth import TrueParameter, Truth

__all__ = [
    "Instrument",
    "Period",
    "ReportConditions",
    "ReportInput",
    "Row",
    "Section",
    "TrueParameter",
    "Truth",
    "Verdict",
    "write_identification_report",
    "write_table_report",
]
