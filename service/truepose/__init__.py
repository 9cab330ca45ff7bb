"""The truepose service: measures, identifies and validates industrial robots."""

__version__ = "0.1.0"
