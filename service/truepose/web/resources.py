"""Routers of the API: each route has what all of the API share when it is made.

The framework makes every route of a router once more where another one includes it, and the service would
start a tenth later: whoever gathers routers takes their routes as they are.
"""

from collections.abc import Sequence
from typing import Final

from fastapi import APIRouter
from fastapi.routing import APIRoute
from starlette.types import Receive, Scope, Send

from truepose.web.problems import problems
from truepose.web.requests.queries import require_known_parameters

_PREFIX: Final = "/api/v1"


class _Operation(APIRoute):
    """An operation that refuses a query that it does not understand."""

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request at the path of the operation."""
        if scope["query_string"] and scope["method"] in (self.methods or ()):
            require_known_parameters(self, scope)
        await super().handle(scope, receive, send)


def resource(prefix: str = "", *, tags: Sequence[str] = ()) -> APIRouter:
    """Return the router of a resource of the API."""
    return APIRouter(
        prefix=_PREFIX + prefix,
        tags=[*tags],
        route_class=_Operation,
        responses=problems(401, 403, 422),
        generate_unique_id_function=_operation_id,
    )


def outside_the_api(*, tags: Sequence[str]) -> APIRouter:
    """Return the router of what programs ask for that is in no version of the API."""
    return APIRouter(tags=[*tags], generate_unique_id_function=_operation_id)


def _operation_id(route: APIRoute) -> str:
    """Return what programs call an operation: the name of its function, as `start_session`."""
    return route.name
