"""What results tell about a robot (figures, verdicts, causes), added from each page of a journal.

A record of a form that nobody here knows raises one of UNKNOWN_FORM. A figure that is not finite tells
nothing: no page can show it, and not every database keeps it.
"""

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal, TypeAlias

from sqlalchemy import Connection

from truepose.storage.plant.cells import newest_row
from truepose.storage.plant.certificates import add_certificates, stated_certificates
from truepose.storage.plant.records import Branch, CollectedLink, Document, day_of, document_in
from truepose.storage.plant.tables import plant_results, plant_told
from truepose.storage.record_insertion import add_row
from truepose.storage.results.items import validation_state
from truepose.storage.rows import to_row

ToldKind: TypeAlias = Literal["session", "campaign", "identification", "diagnosis", "validation", "model"]
# Whatever reading an unknown document may raise. No error of the storage is among them: those end the
# transaction.
UNKNOWN_FORM: Final = (
    ArithmeticError,
    AttributeError,
    LookupError,
    RecursionError,
    TypeError,
    ValueError,
)


@dataclass(frozen=True, slots=True)
class Projection:
    """What one record tells."""

    kind: ToldKind
    verdict: str = ""  # empty: it judges nothing
    figure_mm: float | None = None
    limit_mm: float | None = None
    document: Document = field(default_factory=dict)
    made_of: tuple[ToldKind, int] | None = None  # what it was made of in the same cell


def telling(record: str, row: Document) -> Projection | None:
    """Return what a record tells; None: nothing, whatever is in it."""
    read = TELLING.get(record)
    return None if read is None else _finite(read(row))


def _finite(told: Projection) -> Projection:
    figure_mm, limit_mm = _figure(told.figure_mm), _figure(told.limit_mm)
    return replace(told, figure_mm=figure_mm, limit_mm=limit_mm, document=_of_finite(told.document))


def _of_finite(value: Any) -> Any:
    match value:
        case dict():
            return {name: _of_finite(one) for name, one in value.items()}
        case list():
            return [_of_finite(one) for one in value]
        case float():
            return _figure(value)
        case _:
            return value


def _figure(value: Any) -> float | None:
    """Return a figure; None: there is none, or it is infinite, which documents say as text."""
    # To Python a truth value is an int: "true" would be a figure of 1 mm.
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and math.isfinite(value) else None


def _session(row: Document) -> Projection:
    cell = document_in(row, "setup").get("cell", {})
    tool, base = cell.get("tool") or {}, cell.get("base_nominal") or {}
    named = [str(tool.get(name) or "") for name in ("name", "serial_number")]
    return Projection("session", document={"tool": " ".join(filter(None, named)), "base": [*base.values()]})


def _campaign(row: Document) -> Projection:
    sessions = document_in(row, "session_ids")
    return Projection("campaign", made_of=("session", int(sessions[0])) if sessions else None)


def _identification(row: Document) -> Projection:
    found = document_in(row, "document")
    held_out = found.get("validation") or found.get("cross_validation") or {}
    after, before = (_mean(held_out.get(model)) for model in ("identified", "nominal"))
    told = {"before_mm": before, "quantity": found.get("quantity")}
    return Projection("identification", str(found["status"]), after, None, told, _of(row, "campaign"))


def _diagnosis(row: Document) -> Projection:
    found = document_in(row, "summary")
    told = {
        "before_mm": _mean(found.get("nominal")),  # `before` is of the model that it starts from
        "quantity": found.get("quantity"),
        "asks": len(found.get("next_measurements", ())),
        "causes": [_cause(finding) for finding in found["findings"]],
    }
    after = _mean(found.get("after"))
    return Projection("diagnosis", str(found["verdict"]), after, None, told, _of(row, "campaign"))


def _cause(finding: Document) -> dict[str, Any]:
    known = ("effect", "subject", "unit", "amplitude", "amplitude_standard_uncertainty")
    figures = {name: _figure(finding[name]) for name in known if name.startswith("amplitude")}
    worth = finding.get("worth")
    return {name: finding[name] for name in known} | figures | {"worth_mm": _mean(worth)}


def _validation(row: Document) -> Projection:
    found = document_in(row, "document")
    identified, limit = found["position"]["identified"], found["limit_mm"]
    figure = identified["mean_mm"] if limit is None else identified["max_mm"]
    told = {
        "promised": limit is None,
        "model": row.get("model_id"),
        "quantity": found.get("quantity"),
        "before_mm": _mean(found["position"].get("nominal")),
        "after_mm": _mean(identified),
    }
    allowed = found.get("claimed_mm") if limit is None else limit
    return Projection("validation", validation_state(found), figure, allowed, told, _of(row, "campaign"))


def _model(row: Document) -> Projection:
    diagnosed = row.get("diagnosis_id") is not None
    accepted_by = row.get("accepted_by")  # of one that was handed down
    told = {} if accepted_by is None else {"accepted_by": str(accepted_by)}
    return Projection(
        "model", document=told, made_of=_of(row, "diagnosis" if diagnosed else "identification")
    )


def _of(row: Document, kind: ToldKind) -> tuple[ToldKind, int] | None:
    number = row.get(f"{kind}_id")
    return None if number is None else (kind, int(number))


def _mean(statistics: Document | None) -> float | None:
    return None if statistics is None else _figure(statistics.get("mean_mm"))


TELLING: Final[Mapping[str, Callable[[Document], Projection]]] = {
    "sessions": _session,
    "campaigns": _campaign,
    "identifications": _identification,
    "diagnoses": _diagnosis,
    "validations": _validation,
    "models": _model,
}


_LOG: Final = logging.getLogger(__name__)
_CARRIED: Final = ("tool", "base")  # what the robot was measured with: the same for all that was made of it


def tell(connection: Connection, branch: Branch, link: CollectedLink, row: Document) -> None:
    """Add what a record tells, inside the caller's transaction; what it is of was added before.

    One of a form that this version does not know tells nothing.
    """
    try:
        found, papers = telling(link.record, row), stated_certificates(link.record, row)
        if found is not None:
            _add(connection, branch, link, found, day_of(row))
        add_certificates(connection, branch, link, papers)
    except UNKNOWN_FORM as error:
        _LOG.warning("record %d of the %s tells nothing (%r)", link.record_id, link.record, error)


def _add(connection: Connection, branch: Branch, link: CollectedLink, found: Projection, day: str) -> None:
    serial, measured_on = _of_whom(connection, branch, found.kind, link.record_id, day)
    carried = {} if found.made_of is None else _carried(connection, branch, *found.made_of)
    add_row(
        connection,
        plant_told,
        branch_id=branch.id,
        link=link.link,
        record_id=link.record_id,
        robot_serial_number=serial,
        measured_on=measured_on,
        **to_row(replace(found, document={**carried, **found.document}), plant_told),
    )


def _of_whom(
    connection: Connection, branch: Branch, kind: ToldKind, record_id: int, day: str
) -> tuple[str, str]:
    """Return serial number of the robot and day of measuring, as they stand beside the result.

    Which robot answers in a session is known with what is made of it.
    """
    if kind == "session":
        return "", day
    result = (plant_results.c.kind == kind) & (plant_results.c.record_id == record_id)
    found = newest_row(connection, branch, plant_results, result, by_link=True)
    return ("", "") if found is None else (found.robot_serial_number, found.measured_on)


def _carried(connection: Connection, branch: Branch, kind: ToldKind, record_id: int) -> dict[str, Any]:
    origin = (plant_told.c.kind == kind) & (plant_told.c.record_id == record_id)
    found = newest_row(connection, branch, plant_told, origin, by_link=True)
    told = {} if found is None else found.document
    return {name: told[name] for name in _CARRIED if name in told}
