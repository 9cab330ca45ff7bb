"""Routers of the API: each route has what all of the API share when it is made.

The framework makes every route of a router once more where another one includes it, and the service would
start a tenth later: whoever gathers routers takes their routes as they are.
"""

from collections.abc import Sequence
from typing import Final

from fastapi import APIRouter, Depends
from fastapi.routing import APIRoute

from truepose.web.problems import problems
from truepose.web.requests.queries import only_known_parameters

_PREFIX: Final = "/api/v1"


def resource(prefix: str = "", *, tags: Sequence[str] = ()) -> APIRouter:
    """Return the router of a resource of the API."""
    return APIRouter(
        prefix=_PREFIX + prefix,
        tags=[*tags],
        dependencies=[Depends(only_known_parameters)],
        responses=problems(401, 403, 422),
        generate_unique_id_function=_operation_id,
    )


def outside_the_api(*, tags: Sequence[str]) -> APIRouter:
    """Return the router of what programs ask for that is in no version of the API."""
    return APIRouter(tags=[*tags], generate_unique_id_function=_operation_id)


def _operation_id(route: APIRoute) -> str:
    """Return what programs call an operation: the name of its function, as `start_session`."""
    return route.name
