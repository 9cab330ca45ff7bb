"""The composition root: settings -> storage -> drivers -> routes; the one place that knows everything."""

from truepose.app.composition import create_app
from truepose.app.server import serve

__all__ = ["create_app", "serve"]
