"""Every kind of report."""

from typing import Final

from truepose.web.reports.corrections import CORRECTION
from truepose.web.reports.diagnoses import DIAGNOSIS
from truepose.web.reports.identifications import IDENTIFICATION
from truepose.web.reports.kinds import ReportKind
from truepose.web.reports.sessions import SESSION
from truepose.web.reports.validations import VALIDATION

KINDS: Final[dict[str, ReportKind]] = {
    kind.name: kind for kind in (IDENTIFICATION, VALIDATION, DIAGNOSIS, SESSION, CORRECTION)
}
