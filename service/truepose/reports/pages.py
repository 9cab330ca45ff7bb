"""Templates to a file: everything a page needs goes into it, and user text is escaped."""

import functools
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from truepose.reports.causes_found.ruled_out import ruled_out_rows
from truepose.reports.paper import PAPER, write_report_text
from truepose.reports.traceability.imprint import css_string
from truepose.reports.wording.rounding import millimetres, p_value, uncertainty_mm
from truepose.version import __version__
from truepose.words.catalogue import IN_ENGLISH, Catalogue
from truepose.words.templates import in_units


def write_page(path: Path, template: str, **context: object) -> None:
    """Render a template into a file, HTML or PDF by its name; raises as `write_report_text` does."""
    write_report_text(path, rendered(template, **context))


def content_of(page: str) -> Markup:
    """Return what a whole page shows within its frame."""
    return Markup(page.partition("<main>")[2].rpartition("</main>")[0])


def rendered(template: str, **context: object) -> Markup:
    """Return a template of this package, filled in; in English where no `words` are given."""
    given = {"words": IN_ENGLISH, "say": IN_ENGLISH.say, "version": __version__, "paper": PAPER}
    spoken = given | {"imprint": None, "front": None} | context
    return Markup(_environment().get_template(template).render(spoken))


def page_styles() -> Markup:
    """Return the style sheet of all reports, for a page that shows one within its own frame."""
    return rendered("style.css")


def page_tokens() -> Markup:
    """Return the colours that everything is shown in, as a style sheet."""
    return rendered("tokens.css")


def verdict_shape(look: str) -> Markup:
    """Return the shape that stands for a verdict; `look` as `VerdictWords` names it."""
    return rendered("shape.html", look=look)


@functools.cache  # it keeps the templates that it has compiled
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("truepose.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=in_units,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(mm=millimetres, u=uncertainty_mm, p=p_value, capitalize_first=_capitalized)
    environment.filters.update(joined=ruled_out_rows, called=_called, css_string=css_string)
    return environment


def _called(effect: str, words: Catalogue) -> str:
    return words.effect(effect)


def _capitalized(text: str) -> str:
    """Return the text with a capital first letter; jinja's own would make small letters of all others."""
    return text[:1].upper() + text[1:]
