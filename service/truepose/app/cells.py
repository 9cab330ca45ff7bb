"""Serves a cell."""

from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from truepose.app.composition import open_context
from truepose.app.server import Served, run
from truepose.settings import Settings
from truepose.web.application import create_application
from truepose.web.context import Context


def serve(settings: Settings) -> int:
    """Serve a cell until interrupted, as `run` does."""

    def opened(lines_lost: Callable[[], int]) -> AbstractAsyncContextManager[Context]:
        return open_context(settings, lines_lost=lines_lost)

    return run(settings, Served(opened, create_application))
