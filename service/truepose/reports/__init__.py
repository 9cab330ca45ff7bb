"""Reports: self-contained HTML pages and short text tables from results.

Names are loaded when they are first used: a text table needs no figures, whose library takes longer to import
than an identification takes.
"""

from typing import TYPE_CHECKING

from truepose.lazy_names import loader

if TYPE_CHECKING:
    from truepose.reports.diagnosis_report import DiagnosisInput, diagnosis_content, write_diagnosis_report
    from truepose.reports.identification_report import DiagnosisLink, ReportInput, write_identification_report
    from truepose.reports.pages import page_styles, page_tokens, verdict_shape
    from truepose.reports.table_report import Row, Section, Trend, Verdict, write_table_report
    from truepose.reports.traceability.conditions import Instrument, Period, ReportConditions
    from truepose.reports.truth import TrueParameter, Truth
    from truepose.reports.validation.report import ValidationInput, write_validation_report
    from truepose.reports.wording.causes import VerdictWords, verdict_words

__all__ = [
    "DiagnosisInput",
    "DiagnosisLink",
    "Instrument",
    "Period",
    "ReportConditions",
    "ReportInput",
    "Row",
    "Section",
    "Trend",
    "TrueParameter",
    "Truth",
    "ValidationInput",
    "Verdict",
    "VerdictWords",
    "diagnosis_content",
    "page_styles",
    "page_tokens",
    "verdict_shape",
    "verdict_words",
    "write_diagnosis_report",
    "write_identification_report",
    "write_table_report",
    "write_validation_report",
]

_HOMES = {
    "DiagnosisInput": "diagnosis_report",
    "DiagnosisLink": "identification_report",
    "Instrument": "traceability.conditions",
    "Period": "traceability.conditions",
    "ReportConditions": "traceability.conditions",
    "ReportInput": "identification_report",
    "Row": "table_report",
    "Section": "table_report",
    "Trend": "table_report",
    "TrueParameter": "truth",
    "Truth": "truth",
    "ValidationInput": "validation.report",
    "Verdict": "table_report",
    "VerdictWords": "wording.causes",
    "diagnosis_content": "diagnosis_report",
    "page_styles": "pages",
    "page_tokens": "pages",
    "verdict_shape": "pages",
    "verdict_words": "wording.causes",
    "write_diagnosis_report": "diagnosis_report",
    "write_identification_report": "identification_report",
    "write_table_report": "table_report",
    "write_validation_report": "validation.report",
}

if not TYPE_CHECKING:  # to a type checker every misspelt name would be one of ours
    __getattr__ = loader(__name__, _HOMES)
