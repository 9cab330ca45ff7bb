"""Templates to a file: everything a page needs goes into it, and user text is escaped."""

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from service import __version__
from service.reports.errors import UnwritableReportError
from service.reports.rounding import millimetres, p_value, uncertainty


def write_page(path: Path, template: str, **context: object) -> None:
    """Render a template of this package into a file, making its folder where needed.

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    """
    text = _environment().get_template(template).render(version=__version__, **context)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UnwritableReportError(
            f"The report cannot be written to {path} ({error.strerror}); choose another file."
        ) from error


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("service.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(mm=millimetres, u=uncertainty, p=p_value)
    return environment
