"""Numbers of templates in the units of who reads the page."""

from typing import Any

from jinja2 import pass_context
from jinja2.runtime import Context

from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.units import ConvertibleNumber


@pass_context
def in_units(context: Context, value: Any) -> Any:
    """Return what a template prints: a printed number in the units of the page's words."""
    if not isinstance(value, ConvertibleNumber):
        return value
    return context.get("words", IN_ENGLISH).units.printed(value)
