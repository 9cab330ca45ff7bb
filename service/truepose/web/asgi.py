"""The ASGI application of any routes: its middleware, problem documents, and a complete OpenAPI document."""

import contextlib
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager
from typing import Any, Final, Protocol, TypeAlias

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware
from starlette.routing import BaseRoute
from starlette.types import ASGIApp

from truepose.storage.database import Database
from truepose.web import problems
from truepose.web.api.chain import LINES
from truepose.web.middleware.authorization import AuthorizationMiddleware
from truepose.web.middleware.hosts import AllowedHosts, Proxies
from truepose.web.middleware.language import LanguageMiddleware
from truepose.web.middleware.limits import RequestLimits
from truepose.web.middleware.metrics import Metrics
from truepose.web.middleware.priority import ConcurrencyLimits
from truepose.web.middleware.request_log import RequestLog
from truepose.web.middleware.rights import require_complete
from truepose.web.middleware.routing import Routing, operations_of
from truepose.web.middleware.security import SecurityMiddleware
from truepose.web.openapi_examples import add_examples
from truepose.web.resources import correct_parameters

Application: TypeAlias = FastAPI


class RouteContext(Protocol):
    """What is behind the routes of an application."""

    @property
    def database(self) -> Database:
        """Where records are kept."""


OpenContext: TypeAlias = Callable[[], AbstractAsyncContextManager[RouteContext]]
_AS_IT_IS: Final = (
    *DEFAULT_EXCLUDED_CONTENT_TYPES,
    "application/pdf",
    "application/octet-stream",
    LINES,
)
_DESCRIPTION: Final = (
    "Measures industrial robots, identifies the errors of their nominal model, validates the "
    "result and diagnoses the causes of the residual errors. Every quantity names its unit; "
    "angles are in degrees. Errors are problem documents (RFC 9457) with an explanation in "
    "`detail`. Any request may be answered with 401 if nobody is signed in, 403 if the role of "
    "the caller is insufficient or a browser sends the request from another site's page, 415 "
    "if it is a form, 421 if it names a host other than the service, and 503 with Retry-After "
    "if too many requests are in progress. Programs send their token as `Authorization: "
    "Bearer`. This software is not the safety function: nothing moves until a named person has "
    "confirmed, and the emergency stop must stay within reach."
)


class _SecuredApplication(FastAPI):
    """Has security before everything, the framework's own answer to a failure included."""

    def __init__(self, hosts: AllowedHosts, proxies: Proxies, **options: Any) -> None:
        super().__init__(**options)
        self._hosts = hosts
        self._proxies = proxies
        self.state.metrics = Metrics()

    def build_middleware_stack(self) -> ASGIApp:
        secured = SecurityMiddleware(super().build_middleware_stack(), self._hosts, self._proxies)
        # Around all that may refuse, so that refusals are in the reader's words too.
        return RequestLog(LanguageMiddleware(secured), self.state.metrics)


def application_of(
    routes: Sequence[BaseRoute],
    version: str,
    open_context: OpenContext,
    hosts: AllowedHosts | None = None,
    proxies: Proxies | None = None,
) -> Application:
    """Return the application of these routes.

    It opens its context when it starts and closes it when it ends.

    It answers requests for `hosts` alone; where none are given, for those of loopback. Who asks is who has
    the connection, and behind one of `proxies` whom that tells. Raises MissingRightError where nobody has
    said who may ask for one of its operations.
    """

    @contextlib.asynccontextmanager
    async def lifespan(started: FastAPI) -> AsyncIterator[None]:
        async with open_context() as context:
            started.state.context = context
            context.database.commits.told = started.state.metrics.committed
            yield

    app = _SecuredApplication(
        hosts or AllowedHosts(),
        proxies or Proxies(),
        title="truepose",
        version=version,
        description=_DESCRIPTION,
        lifespan=lifespan,
        # FastAPI's own pages load their scripts from a content network; a shop floor has none.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
        strict_content_type=False,  # `RequestLimits` answers 415 with a sentence
    )
    app.router.routes += routes
    app.router.middleware_stack = Routing(app.router.middleware_stack, app.routes)
    problems.install(app)
    # What is added last is outermost: who asks is known before a body is read (decision 0057), and a body is
    # received before its request takes a place (decision 0022).
    app.add_middleware(ConcurrencyLimits)
    app.add_middleware(RequestLimits)
    operations = operations_of(app.routes)
    require_complete(operation.name for operation in operations)
    app.add_middleware(AuthorizationMiddleware, operations=operations)
    # Outermost, so that refusals are compressed as well; streams and what is packed already are left alone.
    app.add_middleware(GZipMiddleware, minimum_size=1024, compresslevel=5, exclude_content_types=_AS_IT_IS)
    _complete_openapi(app)
    return app


def _complete_openapi(app: FastAPI) -> None:
    """Let the document define the problem schema that every route refers to."""

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = get_openapi(
                title=app.title, version=app.version, description=app.description, routes=app.routes
            )
            schemas = app.openapi_schema.setdefault("components", {}).setdefault("schemas", {})
            schemas["Problem"] = problems.Problem.model_json_schema()
            correct_parameters(app.openapi_schema)
            _summarise(app.openapi_schema)
            add_examples(app.openapi_schema)
        return app.openapi_schema

    app.openapi = document  # type: ignore[method-assign]  # the framework's own way to extend it


def _summarise(document: dict[str, Any]) -> None:
    """Let the first line of each description be its summary; the framework's is the name of a function."""
    for methods in document["paths"].values():
        for operation in methods.values():
            operation["summary"] = operation["description"].partition("\n")[0].rstrip(".")
