"""Every route of an application, however it was put together, and requests as no client sends them."""

import contextlib
import functools
import json
import re
from dataclasses import dataclass

from truepose.web.application import create_application

METHODS = ("GET", "HEAD", "OPTIONS", "POST", "PUT", "PATCH", "DELETE", "TRACE")


@functools.cache
def routes_alone():
    """Return an application with all routes and no service behind them, made once in a process."""
    return create_application("test", contextlib.nullcontext)


def document():
    """Return what describes the API; it takes a second once, too long while modules are imported."""
    return routes_alone().openapi()


def _routes_of(app):
    left = list(app.routes)
    while left:
        route = left.pop()
        inner = getattr(route, "effective_candidates", None)
        if inner is None:
            yield route
        else:
            left += inner()


def paths_of(app):
    """Return the templates of all paths: of the API, of pages, of files that are not in the document."""
    return sorted({route.path for route in _routes_of(app)})


def operations_of(app):
    """Return the methods and path templates of the API, as the document has them."""
    of_api = [route for route in _routes_of(app) if getattr(route, "include_in_schema", False)]
    return sorted((method.lower(), route.path) for route in of_api for method in route.methods)


def paths_answering(app, kind):
    """Return the templates of the paths whose answer is stated to be of that class."""
    return {route.path for route in _routes_of(app) if getattr(route, "response_class", None) is kind}


def addresses_of(app):
    """Return an address for each path, and some for which there is no route."""
    filled = [re.sub(r"{[^}]+}", "1", path) for path in paths_of(app)]
    style = "/static/tablet/common/tablet.css"
    return [*filled, "/nothing", "/api/v1/nothing", style, "//", "/%2e%2e/health"]


@dataclass
class Answer:
    status: int
    headers: dict
    body: bytes

    @property
    def detail(self):
        return json.loads(self.body)["detail"]


async def asked(app, method="GET", path="/", headers=(("host", "localhost:8000"),), body=b""):
    """Ask an application with these headers and no others; return what it sent, or its failure's answer."""
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "scheme": "http",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"stop_after_s=0.01",
        "root_path": "",
        "headers": [(name.encode(), value.encode("latin-1")) for name, value in headers],
        "client": ("127.0.0.1", 50_000),
        "server": ("127.0.0.1", 8000),
        "state": {},
    }
    sent = []
    coming = [{"type": "http.request", "body": body, "more_body": False}]

    async def receive():
        return coming.pop() if coming else {"type": "http.disconnect"}

    async def send(message):
        sent.append(message)

    try:
        await app(scope, receive, send)
    except Exception:
        # The framework answers 500 and lets the server know; here the answer counts.
        if not sent:
            raise
    starts = [message for message in sent if message["type"] == "http.response.start"]
    assert len(starts) == 1
    told = {name.decode(): value.decode() for name, value in starts[0]["headers"]}
    assert len(told) == len(starts[0]["headers"]), "a header is there twice"
    return Answer(starts[0]["status"], told, b"".join(m.get("body", b"") for m in sent[1:]))
