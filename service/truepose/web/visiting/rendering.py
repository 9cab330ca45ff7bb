"""Templates of the pages for people."""

from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from truepose.words.templates import in_units

_HERE: Final = Path(__file__).parents[1]
_TEMPLATES: Final = Environment(
    loader=FileSystemLoader([_HERE / "templates", _HERE / "tablet" / "templates"]),
    autoescape=True,
    undefined=StrictUndefined,
    finalize=in_units,
)
_TEMPLATES.globals["parts"] = _TEMPLATES.get_template("parts.html").module


def rendered(template: str, **context: object) -> str:
    """Return a template of this package, filled in."""
    return _TEMPLATES.get_template(template).render(**context)


def prepare(*beginnings: str) -> None:
    """Compile templates whose names begin so, a tenth of a second of work, before somebody waits for it."""
    for name in _TEMPLATES.list_templates():
        if name.startswith(beginnings):
            _TEMPLATES.get_template(name)
