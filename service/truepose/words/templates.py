"""Numbers of templates in the units of who reads the page."""

from typing import Any

from jinja2 import pass_context
from jinja2.runtime import Context

from truepose.words.catalogue import IN_ENGLISH
from truepose.words.units import Printed


@pass_context
def in_units(context: Context, value: Any) -> Any:
    """Return what a template prints: a printed number in the units of the page's words."""
    if not isinstance(value, Printed):
        return value
    return context.get("words", IN_ENGLISH).units.printed(value)
