"""Reports: self-contained HTML pages and short text tables from results."""

from truepose.reports.causes import VerdictWords, verdict_words
from truepose.reports.conditions import Instrument, Period, ReportConditions
from truepose.reports.diagnosis_report import DiagnosisInput, diagnosis_content, write_diagnosis_report
from truepose.reports.identification_report import DiagnosisLink, ReportInput, write_identification_report
from truepose.reports.pages import page_styles, verdict_shape
from truepose.reports.table_report import Row, Section, Verdict, write_table_report
from truepose.reports.truth import TrueParameter, Truth

__all__ = [
    "DiagnosisInput",
    "DiagnosisLink",
    "Instrument",
    "Period",
    "ReportConditions",
    "ReportInput",
    "Row",
    "Section",
    "TrueParameter",
    "Truth",
    "Verdict",
    "VerdictWords",
    "diagnosis_content",
    "page_styles",
    "verdict_shape",
    "verdict_words",
    "write_diagnosis_report",
    "write_identification_report",
    "write_table_report",
]
