"""Templates to a file: everything a page needs goes into it, and user text is escaped."""

import functools

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.templates import in_units
from truepose.reports.paper import PAPER
from truepose.reports.rounding import millimetres, p_value, uncertainty_mm
from truepose.reports.traceability import css_string
from truepose.version import __version__


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
    environment.filters.update(mm=millimetres, u=uncertainty_mm, p=p_value, capitalize_first=capitalise)
    environment.filters.update(called=_called, css_string=css_string)
    return environment


def _called(effect: str, words: Catalogue) -> str:
    return words.effect(effect)


def capitalise(text: str) -> str:
    """Return the text with a capital first letter; jinja's own would make small letters of all others."""
    return text[:1].upper() + text[1:]
