"""What records tell about a robot beyond of whom they are: figures, verdicts, causes, what it carried.

Pure: a record as it was collected in, what it tells out. A record of a form that nobody here knows raises
LookupError, ValueError, TypeError or AttributeError.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias

Document: TypeAlias = Mapping[str, Any]
ToldKind: TypeAlias = Literal["session", "campaign", "identification", "diagnosis", "validation", "model"]
PASSED: Final = "passed"
FAILED: Final = "failed"


@dataclass(frozen=True, slots=True)
class Telling:
    """What one record tells."""

    kind: ToldKind
    verdict: str = ""  # empty: it judges nothing
    figure_mm: float | None = None
    limit_mm: float | None = None
    document: Document = field(default_factory=dict)
    made_of: tuple[ToldKind, int] | None = None  # what it was made of in the same cell


def telling(record: str, row: Document) -> Telling | None:
    """Return what a record tells; None: nothing, whatever is in it."""
    read = TELLING.get(record)
    return None if read is None else read(row)


def _session(row: Document) -> Telling:
    cell = _json(row, "setup").get("cell", {})
    tool, base = cell.get("tool") or {}, cell.get("base_nominal") or {}
    named = [str(tool.get(name) or "") for name in ("name", "serial_number")]
    return Telling("session", document={"tool": " ".join(filter(None, named)), "base": [*base.values()]})


def _campaign(row: Document) -> Telling:
    sessions = _json(row, "session_ids")
    return Telling("campaign", made_of=("session", int(sessions[0])) if sessions else None)


def _identification(row: Document) -> Telling:
    found = _json(row, "document")
    held_out = found.get("validation") or found.get("cross_validation") or {}
    after, before = (_mean(held_out.get(model)) for model in ("identified", "nominal"))
    told = {"before_mm": before}
    return Telling("identification", str(found["status"]), after, None, told, _of(row, "campaign"))


def _diagnosis(row: Document) -> Telling:
    found = _json(row, "summary")
    told = {
        "before_mm": _mean(found.get("before")),
        "asks": len(found.get("next_measurements", ())),
        "causes": [_cause(finding) for finding in found["findings"]],
    }
    after = _mean(found.get("after"))
    return Telling("diagnosis", str(found["verdict"]), after, None, told, _of(row, "campaign"))


def _cause(finding: Document) -> dict[str, Any]:
    known = ("effect", "subject", "unit", "amplitude", "amplitude_standard_uncertainty")
    return {name: finding[name] for name in known}


def _validation(row: Document) -> Telling:
    found = _json(row, "document")
    identified, limit = found["position"]["identified"], found["limit_mm"]
    figure = identified["mean_mm"] if limit is None else identified["max_mm"]
    told = {"promised": limit is None, "model": row.get("model_id")}
    allowed = found.get("claimed_mm") if limit is None else limit
    verdict = PASSED if found["passed"] else FAILED
    return Telling("validation", verdict, figure, allowed, told, _of(row, "campaign"))


def _model(row: Document) -> Telling:
    diagnosed = row.get("diagnosis_id") is not None
    return Telling("model", made_of=_of(row, "diagnosis" if diagnosed else "identification"))


def _of(row: Document, kind: ToldKind) -> tuple[ToldKind, int] | None:
    number = row.get(f"{kind}_id")
    return None if number is None else (kind, int(number))


def _mean(statistics: Document | None) -> float | None:
    return None if statistics is None else statistics.get("mean_mm")


def _json(row: Document, column: str) -> Any:
    return json.loads(str(row[column]))


TELLING: Final[Mapping[str, Callable[[Document], Telling]]] = {
    "sessions": _session,
    "campaigns": _campaign,
    "identifications": _identification,
    "diagnoses": _diagnosis,
    "validations": _validation,
    "models": _model,
}
