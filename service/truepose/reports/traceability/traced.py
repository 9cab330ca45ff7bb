"""What every result of a session ends with: conditions, devices, and the records behind it."""

from dataclasses import dataclass, replace

from truepose.domain.measurement.campaign import Stops
from truepose.reports.traceability.audit import Audit, audit_rows
from truepose.reports.traceability.conditions import ReportConditions, condition_rows, temperature_range
from truepose.words.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Traced:
    """Of a result: on which robot, under which conditions, from which records."""

    robot: str
    conditions: ReportConditions
    audit: Audit


def traced_context(traced: Traced, words: Catalogue) -> dict[str, object]:
    """Return what the template `traced.html` fills in."""
    return {
        "robot": traced.robot,
        "conditions": traced.conditions,
        "condition_rows": tuple(condition_rows(traced.conditions, words)),
        "audit_rows": tuple(audit_rows(traced.audit, words)),
    }


def with_temperature(conditions: ReportConditions, stops: Stops) -> ReportConditions:
    """Take the range of temperatures from the readings where nobody stated one."""
    if conditions.temperature_c is not None:
        return conditions
    return replace(conditions, temperature_c=temperature_range((stops,)))
