"""The truepose service: measures, identifies and validates industrial robots."""

from truepose.version import __version__

__all__ = ["__version__"]
