"""Parameters behind the question mark: one that an operation does not know is refused, not passed over.

A misspelt `limit` or `superseded` would otherwise be answered with another list than the one asked for.
"""

import difflib
from typing import Any, Final

from fastapi.dependencies.utils import get_flat_params
from fastapi.exceptions import RequestValidationError
from fastapi.params import Query
from fastapi.routing import APIRoute
from starlette.datastructures import QueryParams
from starlette.types import Scope

UNKNOWN_PARAMETER: Final = "unknown_parameter"  # the type of the fault
_ALIKE: Final = 0.7  # `limt` and `limit` 0.89; `state` and `after`, which nobody confuses, 0.6


def require_known_parameters(route: APIRoute, scope: Scope) -> None:
    """Refuse a request with a parameter in its query that its operation does not take.

    Raises
    ------
    RequestValidationError
        Names the first one, and the known one that it resembles most, or all that there are.
    """
    known = _taken(route)
    unknown = next((name for name in QueryParams(scope["query_string"]) if name not in known), None)
    if unknown is not None:
        fault = {"type": UNKNOWN_PARAMETER, "loc": ("query", unknown), "msg": _hint(unknown, known)}
        raise RequestValidationError([fault])


def _taken(route: APIRoute) -> tuple[str, ...]:
    fields = get_flat_params(route.dependant)
    return tuple(field.alias for field in fields if isinstance(field.field_info, Query))


def _hint(unknown: str, known: tuple[str, ...]) -> str:
    if not known:
        return "no parameters are taken here"
    like = difflib.get_close_matches(unknown.lower(), known, n=1, cutoff=_ALIKE)
    told = f"did you mean {like[0]}" if like else f"known are {', '.join(known)}"
    return f"unknown here; {told}"


def drop_null_of_parameters(document: dict[str, Any]) -> None:
    """Let a document say of no parameter that it may be null: no address and no header can say that."""
    for methods in document["paths"].values():
        for operation in methods.values():
            for parameter in operation.get("parameters", []):
                parameter["schema"] = _without_null(parameter["schema"])


def _without_null(schema: dict[str, Any]) -> dict[str, Any]:
    choices = [choice for choice in schema.get("anyOf", []) if choice != {"type": "null"}]
    if len(choices) != 1:
        return schema
    return {**choices[0], **{name: value for name, value in schema.items() if name != "anyOf"}}
