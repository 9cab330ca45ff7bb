"""The composition root: settings -> storage -> drivers -> routes; the one place that knows everything."""

from typing import TYPE_CHECKING

from truepose.lazy_names import loader

if TYPE_CHECKING:
    from truepose.app.composition import create_app, serve

__all__ = ["create_app", "serve"]

if not TYPE_CHECKING:
    __getattr__ = loader(__name__, {"create_app": "composition", "serve": "composition"})
