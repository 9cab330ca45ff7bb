"""The composition root: settings -> storage -> drivers -> routes; the one place that knows everything."""

from service.app.composition import create_app
from service.app.server import serve

__all__ = ["create_app", "serve"]
